//! The bytes of a glTF's buffers: in the binary file, in a data URI, or in a file beside it.

use super::super::{MeshError, MeshOptions, paths::percent_decoded};
use super::refused;
use crate::bytes::{MESH_BYTES, read_file};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;
use gltf::buffer::Source;
use std::path::PathBuf;

/// The bytes of each buffer, at least as many as it says.
pub(super) fn load(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    options: &MeshOptions,
) -> Result<Vec<Vec<u8>>, MeshError> {
    let load = |buffer: gltf::Buffer<'_>| {
        let path = format!("buffers[{}]", buffer.index());
        let bytes = match buffer.source() {
            Source::Bin => {
                blob.take().ok_or_else(|| refused(&path, "the file has no BIN chunk"))?
            }
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => embedded(data).map_err(|problem| refused(&path, problem))?,
                None => beside(uri, options, &path)?,
            },
        };
        if bytes.len() < buffer.length() {
            let problem = format!("{} bytes, not {}", bytes.len(), buffer.length());
            return Err(refused(&path, problem));
        }
        Ok(bytes)
    };
    document.buffers().map(load).collect()
}

/// What follows `data:`.
fn embedded(data: &str) -> Result<Vec<u8>, String> {
    let text = data.split_once(";base64,").map(|(_, text)| text);
    let text = text.ok_or_else(|| "data other than base64 is not supported".to_owned())?;
    STANDARD.decode(text).map_err(|error| error.to_string())
}

/// A file beside the mesh's own.
fn beside(uri: &str, options: &MeshOptions, path: &str) -> Result<Vec<u8>, MeshError> {
    let Some(folder) = &options.folder else {
        return Err(refused(path, format!("{uri:?} is in another file")));
    };
    // Neither as it is nor decoded may it have a root: that is none of this machine's. What is no regular file need not end.
    let names = [PathBuf::from(uri), PathBuf::from(percent_decoded(uri))];
    let mut places = names.iter().filter(|name| !name.is_absolute()).map(|name| folder.join(name));
    let Some(file) = &places.find(|file| file.is_file()) else {
        let problem = format!("{uri:?} is no file relative to {}", crate::shown(folder));
        return Err(refused(path, problem));
    };
    options.opened.add(file);
    read_file(file, MESH_BYTES).map_err(MeshError::io(file))
}
