//! A binary glTF in the making: the JSON document and its one buffer.

use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Accessor, Buffer, Index, Node, Root, Value};
use std::borrow::Cow;
use std::io::{self, Write};

/// A document and its buffer.
#[derive(Default)]
pub(super) struct Document {
    pub(super) root: Root,
    bytes: Vec<u8>,
}

impl Document {
    /// Vectors of N numbers, with their least and largest in each component.
    pub(super) fn vectors<const N: usize>(
        &mut self,
        vectors: &[[f32; N]],
        target: Option<Target>,
    ) -> Index<Accessor> {
        let type_ = match N {
            1 => Type::Scalar,
            3 => Type::Vec3,
            _ => Type::Vec4,
        };
        let end = |start: f32, pick: fn(f32, f32) -> f32| {
            let over = |ends: [f32; N], v: &[f32; N]| std::array::from_fn(|k| pick(ends[k], v[k]));
            Value::from(vectors.iter().fold([start; N], over).to_vec())
        };
        let (min, max) = (end(f32::INFINITY, f32::min), end(f32::NEG_INFINITY, f32::max));
        let bytes = vectors.iter().flatten().flat_map(|x| x.to_le_bytes());
        let accessor = Accessor {
            min: Some(min),
            max: Some(max),
            ..accessor(vectors.len(), ComponentType::F32, type_)
        };
        self.accessor(accessor, bytes, target)
    }

    /// Indices of vertices.
    pub(super) fn indices(&mut self, indices: impl Iterator<Item = u32>) -> Index<Accessor> {
        let indices: Vec<u32> = indices.collect();
        let accessor = accessor(indices.len(), ComponentType::U32, Type::Scalar);
        let bytes = indices.iter().flat_map(|k| k.to_le_bytes());
        self.accessor(accessor, bytes, Some(Target::ElementArrayBuffer))
    }

    fn accessor(
        &mut self,
        accessor: Accessor,
        bytes: impl Iterator<Item = u8>,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let first = self.bytes.len();
        self.bytes.extend(bytes);
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(self.bytes.len() - first),
            byte_offset: Some(USize64::from(first)),
            byte_stride: None,
            name: None,
            target: target.map(Checked::Valid),
            extensions: None,
            extras: Default::default(),
        };
        let view = self.root.push(view);
        self.root.push(Accessor { buffer_view: Some(view), ..accessor })
    }

    /// Writes all, `top` its one scene's only root.
    pub(super) fn write(mut self, top: Node, out: &mut dyn Write) -> io::Result<()> {
        let top = self.root.push(top);
        let scene = gltf::json::Scene {
            extensions: None,
            extras: Default::default(),
            name: None,
            nodes: vec![top],
        };
        self.root.scene = Some(self.root.push(scene));
        self.root.asset.generator = Some(concat!("dcd ", env!("CARGO_PKG_VERSION")).to_owned());
        if !self.bytes.is_empty() {
            self.root.push(Buffer {
                byte_length: USize64::from(self.bytes.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: Default::default(),
            });
        }
        let json = self.root.to_vec().map_err(io::Error::other)?;
        // Two headers of chunks, one of the file, padding.
        let length = json.len() as u64 + self.bytes.len() as u64 + 64;
        if u32::try_from(length).is_err() {
            let problem = format!("{length} bytes are more than a binary glTF can have");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
        }
        let bin = (!self.bytes.is_empty()).then_some(Cow::Owned(self.bytes));
        // The library pads both chunks, and writes the length of the whole itself.
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        Glb { header, json: Cow::Owned(json), bin }.to_writer(out).map_err(io::Error::other)
    }
}

fn accessor(count: usize, component: ComponentType, type_: Type) -> Accessor {
    Accessor {
        buffer_view: None,
        byte_offset: None,
        count: USize64::from(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: Default::default(),
        type_: Checked::Valid(type_),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}
