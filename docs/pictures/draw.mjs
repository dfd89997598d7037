// Draws models in a headless browser: `node draw.mjs '[{"glb": …, "png": …, "time": …, "from": [x, y, z]}, …]'`.
// `time` is that of the animation in seconds, `from` the direction to the camera (glTF's axes: y is up), `zoom`
// divides the distance at which all is in sight.
import { createServer } from 'node:http';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const here = fileURLToPath(new URL('.', import.meta.url));
const views = JSON.parse(process.argv[2]);
const types = { '.html': 'text/html', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };

const server = createServer(async (request, response) => {
  const { pathname } = new URL(request.url, 'http://localhost');
  const model = /^\/model\/(\d+)\.glb$/.exec(pathname);
  try {
    const file = model ? views[model[1]].glb : join(here, normalize(pathname));
    const bytes = await readFile(file);
    response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

const profile = await mkdtemp(join(tmpdir(), 'dcd-pictures-'));
const browser = await chromium.launchPersistentContext(profile, {
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  viewport: { width: 960, height: 600 },
  args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader'],
});
try {
  const page = await browser.newPage();
  page.on('pageerror', (error) => console.error(error.message));
  await page.goto(`http://127.0.0.1:${server.address().port}/page.html`);
  await page.waitForFunction('window.draw !== undefined');
  for (const [index, view] of views.entries()) {
    await page.evaluate(([url, view]) => window.draw(url, view), [`/model/${index}.glb`, view]);
    await writeFile(view.png, await page.screenshot({ type: 'png' }));
    console.log(view.png);
  }
} finally {
  await browser.close();
  server.close();
  await rm(profile, { recursive: true, force: true });
}
