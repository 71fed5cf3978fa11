//! Checked access to typed accessor elements [glTF20 §3.6.2]. Component types are taken from the accessor. Ranges are
//! checked against the available bytes before any allocation. Any alignment is accepted.

use super::document::Document;
use crate::error::{Error, Result};
use ::gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use ::gltf::json::validation::Checked;

/// Elements of an accessor to read.
#[derive(Clone, Copy)]
pub(super) enum Wanted<'a> {
    /// All elements.
    All,
    /// The elements with these ascending indices.
    These(&'a [u32]),
}

impl Wanted<'_> {
    fn len(self, count: usize) -> usize {
        if let Wanted::These(indices) = self { indices.len() } else { count }
    }

    /// Returns the position of element `index` among those that are read.
    fn place(self, index: u32) -> Option<usize> {
        match self {
            Wanted::All => Some(index as usize),
            Wanted::These(indices) => indices.binary_search(&index).ok(),
        }
    }
}

impl Document {
    /// Reads the wanted elements of accessor `index`, each of `N` components, as floats. Normalised integers map to 0
    /// or −1 to 1, others keep their value.
    ///
    /// # Errors
    /// A scene error that names the accessor if it has another shape, its bytes are missing, or the budget is
    /// exhausted.
    ///
    /// # Panics
    /// If a wanted index is not below [`Document::elements_of`].
    pub(super) fn floats<const N: usize>(&self, index: usize, wanted: Wanted) -> Result<Vec<[f32; N]>> {
        let read = |accessor: &Accessor| {
            let kind = vector::<N>(accessor)?;
            let component = float_decoder(kind, accessor.normalized)
                .ok_or_else(|| Error::scene(format!("component type {kind:?} is not for vertices")))?;
            let size = kind.size();
            self.read(accessor, size * N, [0.0; N], wanted, |e| {
                std::array::from_fn(|c| component(&e[c * size..][..size]))
            })
        };
        self.accessor(index).and_then(read).map_err(|e| e.context(format!("accessor {index}")))
    }

    /// Returns the number of elements of accessor `index`, if they have `N` components and their bytes exist.
    ///
    /// # Errors
    /// Otherwise a scene error that names the accessor.
    pub(super) fn elements_of<const N: usize>(&self, index: usize) -> Result<usize> {
        let count = |accessor: &Accessor| {
            let size = vector::<N>(accessor)?.size() * N;
            self.elements(accessor, size)?.map_or_else(|| self.count_without_bytes(accessor.count.0), |e| Ok(e.count))
        };
        self.accessor(index).and_then(count).map_err(|e| e.context(format!("accessor {index}")))
    }

    /// Reads the elements of accessor `index` as vertex indices.
    ///
    /// # Errors
    /// A scene error that names the accessor if its elements are not unsigned scalars, or its bytes are missing.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>> {
        let read = |accessor: &Accessor| {
            let (kind, shape) = kind_and_shape(accessor)?;
            match (index_decoder(kind), shape) {
                (Some(decode), Type::Scalar) => self.read(accessor, kind.size(), 0, Wanted::All, decode),
                _ => Err(Error::scene(format!("{kind:?} {shape:?} elements are not for indices"))),
            }
        };
        self.accessor(index).and_then(read).map_err(|e| e.context(format!("accessor {index}")))
    }

    /// Returns accessor `index`.
    ///
    /// # Errors
    /// A scene error if it does not exist.
    pub(super) fn accessor(&self, index: usize) -> Result<&Accessor> {
        self.root.accessors.get(index).ok_or_else(|| Error::scene("it does not exist"))
    }

    /// Returns the bytes of an accessor's elements of `size` bytes each; `None` if all are zero.
    fn elements(&self, accessor: &Accessor, size: usize) -> Result<Option<Elements<'_>>> {
        let Some(view) = accessor.buffer_view else { return Ok(None) };
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let stride = self.root.buffer_views[view.value()].byte_stride.map_or(size, |s| s.0);
        Elements::new(self.view(view.value())?, offset, stride, size, accessor.count.0).map(Some)
    }

    fn read<T: Copy>(
        &self,
        accessor: &Accessor,
        size: usize,
        zero: T,
        wanted: Wanted,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let bytes = self.elements(accessor, size)?;
        let count = bytes.as_ref().map_or_else(|| self.count_without_bytes(accessor.count.0), |e| Ok(e.count))?;
        self.budget.spend(wanted.len(count), size_of::<T>())?;
        let mut read = match (&bytes, wanted) {
            (Some(bytes), Wanted::All) => (0..count).map(|i| decode(bytes.at(i))).collect(),
            (Some(bytes), Wanted::These(indices)) => indices.iter().map(|&i| decode(bytes.at(i as usize))).collect(),
            (None, _) => vec![zero; wanted.len(count)],
        };
        if let Some(sparse) = &accessor.sparse {
            self.displace(sparse, &mut read, count, size, wanted, decode).map_err(|e| e.context("its sparse part"))?;
        }
        Ok(read)
    }

    /// Overwrites the wanted elements that a sparse accessor of `count` elements substitutes.
    fn displace<T>(
        &self,
        sparse: &Sparse,
        into: &mut [T],
        count: usize,
        size: usize,
        wanted: Wanted,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<()> {
        let invalid = || Error::scene("its indices have a component type that is not for indices");
        let Checked::Valid(kind) = sparse.indices.component_type else { return Err(invalid()) };
        let index = index_decoder(kind.0).ok_or_else(invalid)?;
        let tight = |view, offset, size| Elements::new(self.view(view)?, offset, size, size, sparse.count.0);
        let indices = tight(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, kind.0.size())?;
        let values = tight(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, size)?;
        self.budget.spend(indices.count, kind.0.size() + size)?;
        for i in 0..indices.count {
            let element = index(indices.at(i));
            if element as usize >= count {
                return Err(Error::scene(format!("index {element} is out of range ({count} elements)")));
            }
            if let Some(place) = wanted.place(element) {
                into[place] = decode(values.at(i));
            }
        }
        Ok(())
    }

    /// All-zero elements take no bytes in the file. Their number is limited to the file's bytes, so that memory stays
    /// in proportion.
    fn count_without_bytes(&self, count: u64) -> Result<usize> {
        usize::try_from(count)
            .ok()
            .filter(|&count| count <= self.size)
            .ok_or_else(|| Error::scene(format!("{count} elements without data are more than the file has bytes")))
    }
}

/// Slices of `size` bytes at intervals of `stride`; the last one ends within `bytes`.
struct Elements<'a> {
    bytes: &'a [u8],
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn new(bytes: &'a [u8], offset: u64, stride: usize, size: usize, count: u64) -> Result<Self> {
        if stride < size {
            return Err(Error::scene(format!("a stride of {stride} bytes is less than an element ({size} bytes)")));
        }
        let length =
            count.checked_sub(1).map_or(Some(0), |gaps| gaps.checked_mul(stride as u64)?.checked_add(size as u64));
        let end = length.and_then(|length| length.checked_add(offset)).unwrap_or(u64::MAX);
        if end > bytes.len() as u64 {
            let have = bytes.len();
            return Err(Error::scene(format!("{count} elements end at byte {end} of a buffer view of {have} bytes")));
        }
        // Both fit into usize, since they are at most a slice's length.
        Ok(Elements { bytes, offset: offset as usize, stride, size, count: count as usize })
    }

    fn at(&self, index: usize) -> &'a [u8] {
        &self.bytes[self.offset + index * self.stride..][..self.size]
    }
}

/// Returns the component type of an accessor whose elements have `N` components.
fn vector<const N: usize>(accessor: &Accessor) -> Result<ComponentType> {
    match kind_and_shape(accessor)? {
        (kind, shape) if shape.multiplicity() == N && !is_matrix(shape) => Ok(kind),
        (_, shape) => Err(Error::scene(format!("it has elements of kind {shape:?} where {N} components are needed"))),
    }
}

fn kind_and_shape(accessor: &Accessor) -> Result<(ComponentType, Type)> {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(kind), Checked::Valid(shape)) => Ok((kind.0, shape)),
        _ => Err(Error::scene("its type is not valid")),
    }
}

fn is_matrix(shape: Type) -> bool {
    matches!(shape, Type::Mat2 | Type::Mat3 | Type::Mat4)
}

/// Copies the bytes of one component. [`Elements`] yields no shorter slices.
fn exactly<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

fn index_decoder(kind: ComponentType) -> Option<fn(&[u8]) -> u32> {
    match kind {
        ComponentType::U8 => Some(|b| u32::from(b[0])),
        ComponentType::U16 => Some(|b| u32::from(u16::from_le_bytes(exactly(b)))),
        ComponentType::U32 => Some(|b| u32::from_le_bytes(exactly(b))),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => None,
    }
}

/// Conversions of [glTF20 §3.11]. Signed types have two representations of −1.
fn float_decoder(kind: ComponentType, normalized: bool) -> Option<fn(&[u8]) -> f32> {
    match (kind, normalized) {
        (ComponentType::F32, _) => Some(|b| f32::from_le_bytes(exactly(b))),
        (ComponentType::I8, false) => Some(|b| f32::from(i8::from_le_bytes(exactly(b)))),
        (ComponentType::U8, false) => Some(|b| f32::from(b[0])),
        (ComponentType::I16, false) => Some(|b| f32::from(i16::from_le_bytes(exactly(b)))),
        (ComponentType::U16, false) => Some(|b| f32::from(u16::from_le_bytes(exactly(b)))),
        (ComponentType::I8, true) => Some(|b| (f32::from(i8::from_le_bytes(exactly(b))) / 127.0).max(-1.0)),
        (ComponentType::U8, true) => Some(|b| f32::from(b[0]) / 255.0),
        (ComponentType::I16, true) => Some(|b| (f32::from(i16::from_le_bytes(exactly(b))) / 32767.0).max(-1.0)),
        (ComponentType::U16, true) => Some(|b| f32::from(u16::from_le_bytes(exactly(b))) / 65535.0),
        (ComponentType::U32, _) => None,
    }
}
