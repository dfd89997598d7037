// Khronos's validator over files of glTF: an error or a warning in any of them fails.
import { readFile } from 'node:fs/promises';
import validator from 'gltf-validator';

let faults = 0;
for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(await readFile(file)), { maxIssues: 20 });
  faults += issues.numErrors + issues.numWarnings;
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
  for (const { code, message, pointer } of issues.messages.filter((issue) => issue.severity < 2)) {
    console.error(`${file}: ${code} at ${pointer}: ${message}`);
  }
}
process.exit(faults === 0 && process.argv.length > 2 ? 0 : 1);
