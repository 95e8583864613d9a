//! Accessors: typed elements in the bytes of a buffer, read in place. All bounds are checked when an accessor is opened,
//! so that reading an element cannot fail; nothing is copied (a sparse accessor is looked up by bisection).
//! glTF 2.0, sections 3.6.2 and 5.1; normalised integers by the table of section 3.11.

use super::at::At;
use super::buffers::Buffers;
use eyebox_base::error::Result;

/// The raw document with its buffers.
#[derive(Debug)]
pub(super) struct Document<'a> {
    pub root: At<'a>,
    pub buffers: Buffers<'a>,
    /// The variant of `KHR_materials_variants` that materials are taken of.
    pub variant: Option<usize>,
}

/// The bytes of a buffer view.
pub(super) struct View<'d> {
    pub bytes: &'d [u8],
    stride: Option<usize>,
}

impl<'a> Document<'a> {
    /// The element of the root list `list` that `reference` points at; `what` is one of them in words.
    pub fn find(&self, list: &str, what: &str, reference: &At<'_>) -> Result<At<'a>> {
        let items = match self.root.get(list)? {
            Some(items) => items,
            None => return Err(reference.fault(format!("the asset has no {list}"))),
        };
        let Some(array) = items.json.as_array() else { return Err(items.fault(format!("`{list}` is not a list"))) };
        let index = reference.index(array.len(), what)?;
        let Some(json) = array.get(index) else {
            return Err(reference.fault(format!("{what} {index} does not exist")));
        };
        Ok(At { file: self.root.file, json, pointer: format!("/{list}/{index}") })
    }

    pub fn view(&self, reference: &At<'_>) -> Result<View<'_>> {
        let at = self.find("bufferViews", "buffer view", reference)?;
        let buffer = at.want("buffer")?;
        let index = buffer.index(self.buffers.data.len(), "buffer")?;
        let Some(Some(slice)) = self.buffers.data.get(index) else {
            return Err(buffer.fault(format!("buffer {index} has no uri and is not the .glb's binary chunk")));
        };
        let bytes = self.buffers.bytes(*slice);
        let start = at.count_or("byteOffset", 0)?;
        let length = at.want("byteLength")?.count()?;
        let inside = start.checked_add(length).and_then(|end| bytes.get(start..end));
        let inside = inside.ok_or_else(|| {
            let what = format!("the view claims {length} bytes from byte {start} of buffer {index}");
            at.fault(what).expected(format!("within its {} bytes", bytes.len()))
        })?;
        // A stride of 0 is not valid, yet written by some exporters that mean "packed".
        let stride = match at.get("byteStride")? {
            Some(stride) => {
                stride.number_in(0.0, 252.0)?;
                Some(stride.count()?).filter(|&stride| stride > 0)
            }
            None => None,
        };
        Ok(View { bytes: inside, stride })
    }

    /// Opens the accessor that `reference` points at.
    ///
    /// # Errors
    /// Any index, type, count or range that is wrong, with its place.
    pub fn accessor(&self, reference: &At<'_>) -> Result<Accessor<'_>> {
        let at = self.find("accessors", "accessor", reference)?;
        let count_at = at.want("count")?;
        let count = count_at.count()?;
        if count == 0 {
            return Err(count_at.fault("an accessor without elements").expected("at least 1"));
        }
        let component = Component::read(&at.want("componentType")?)?;
        let kind = at.want("type")?;
        const KINDS: [(&str, usize); 7] =
            [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT2", 4), ("MAT3", 9), ("MAT4", 16)];
        let name = kind.text()?;
        let Some((_, lanes)) = KINDS.into_iter().find(|(known, _)| *known == name) else {
            let names = KINDS.map(|(known, _)| known);
            return Err(kind.fault("unknown accessor type").expected(names.join(", ")).nearest(name, names));
        };
        let normalized = at.get("normalized")?.map_or(Ok(false), |at| at.flag())?;
        let size = component.size() * lanes;
        let dense = match at.get("bufferView")? {
            Some(view) if self.is_placeholder(&view)? => None,
            Some(view) => Some(self.span(&at, &view, count, size)?),
            None => None,
        };
        let sparse = match at.get("sparse")? {
            Some(sparse) => Some(self.sparse(&sparse, count, size)?),
            None => None,
        };
        Ok(Accessor { at, count, component, lanes, normalized, dense, sparse })
    }

    /// Whether the view is in a buffer that says of no place where its bytes are: the specification lets others bring
    /// them, and here nobody does.
    fn is_placeholder(&self, view: &At<'_>) -> Result<bool> {
        let buffer = self.find("bufferViews", "buffer view", view)?.want("buffer")?;
        let index = buffer.index(self.buffers.data.len(), "buffer")?;
        Ok(self.buffers.data.get(index).is_some_and(Option::is_none))
    }

    /// `count` elements of `size` bytes, from `owner.byteOffset` of the view.
    fn span(&self, owner: &At<'_>, view: &At<'_>, count: usize, size: usize) -> Result<Span<'_>> {
        let View { bytes, stride } = self.view(view)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(view.fault(format!("elements of {size} bytes in a view with byteStride {stride}")));
        }
        let start = owner.count_or("byteOffset", 0)?;
        let end = (count - 1).checked_mul(stride).and_then(|last| last.checked_add(size)?.checked_add(start));
        let inside = end.and_then(|end| bytes.get(start..end)).ok_or_else(|| {
            let what = format!("{count} elements of {size} bytes, {stride} apart, from byte {start} of the view");
            owner.fault(what).expected(format!("within its {} bytes", bytes.len()))
        })?;
        Ok(Span { bytes: inside, stride })
    }

    fn sparse(&self, at: &At<'_>, count: usize, size: usize) -> Result<Sparse<'_>> {
        let count_at = at.want("count")?;
        let changed = count_at.count()?;
        if changed == 0 || changed > count {
            return Err(count_at.fault(format!("{changed} sparse elements")).expected(format!("1 to {count}")));
        }
        let (indices, values) = (at.want("indices")?, at.want("values")?);
        let component_at = indices.want("componentType")?;
        let component = Component::read(&component_at)?;
        if !component.is_index() {
            return Err(component_at.fault("sparse indices of this type").expected("5121, 5123 or 5125"));
        }
        let sparse = Sparse {
            count: changed,
            component,
            indices: self.span(&indices, &indices.want("bufferView")?, changed, component.size())?,
            values: self.span(&values, &values.want("bufferView")?, changed, size)?,
        };
        let mut before = None;
        for i in 0..changed {
            let index = sparse.index(i);
            if index >= count || before.is_some_and(|before| index <= before) {
                let what = format!("sparse index {index} at position {i}");
                return Err(indices.fault(what).expected(format!("strictly increasing, below {count}")));
            }
            before = Some(index);
        }
        Ok(sparse)
    }
}

/// The numeric type of a component, by its OpenGL number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(at: &At<'_>) -> Result<Self> {
        Ok(match at.count()? {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            other => {
                let fault = at.fault(format!("component type {other}"));
                return Err(fault.expected("5120, 5121, 5122, 5123, 5125 or 5126"));
            }
        })
    }
    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
    pub fn is_index(self) -> bool {
        match self {
            Component::U8 | Component::U16 | Component::U32 => true,
            Component::I8 | Component::I16 | Component::F32 => false,
        }
    }
}

/// Elements at equal distances; the bytes are known to hold as many as the accessor counts.
#[derive(Debug)]
struct Span<'d> {
    bytes: &'d [u8],
    stride: usize,
}

impl Span<'_> {
    fn bytes<const N: usize>(&self, element: usize, offset: usize) -> [u8; N] {
        let start = element * self.stride + offset;
        self.bytes.get(start..start + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
    }
    fn floats<const N: usize>(&self, element: usize) -> [f32; N] {
        let start = element * self.stride;
        let bytes = self.bytes.get(start..start + 4 * N).unwrap_or_default();
        let mut out = [0.0; N];
        for (lane, bytes) in out.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *lane = f32::from_le_bytes(*bytes);
        }
        out
    }
    fn unsigned(&self, element: usize, component: Component) -> u32 {
        match component {
            Component::U8 => u32::from(self.bytes::<1>(element, 0)[0]),
            Component::U16 => u32::from(u16::from_le_bytes(self.bytes(element, 0))),
            Component::U32 => u32::from_le_bytes(self.bytes(element, 0)),
            // Not index types: refused before.
            Component::I8 | Component::I16 | Component::F32 => 0,
        }
    }
}

#[derive(Debug)]
struct Sparse<'d> {
    count: usize,
    component: Component,
    indices: Span<'d>,
    values: Span<'d>,
}

impl Sparse<'_> {
    fn index(&self, i: usize) -> usize {
        self.indices.unsigned(i, self.component) as usize
    }
    /// Where the replacement of `element` stands among the values.
    fn position(&self, element: usize) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.index(middle).cmp(&element) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some(middle),
            }
        }
        None
    }
}

/// A checked accessor.
#[derive(Debug)]
pub(super) struct Accessor<'d> {
    pub at: At<'d>,
    pub count: usize,
    pub component: Component,
    pub lanes: usize,
    pub normalized: bool,
    /// None, without a view or with one that has no bytes: all elements are zero but for the sparse ones.
    dense: Option<Span<'d>>,
    sparse: Option<Sparse<'d>>,
}

impl Accessor<'_> {
    /// Whether any bytes stand behind the elements.
    pub fn is_backed(&self) -> bool {
        self.dense.is_some() || self.sparse.is_some()
    }

    /// Elements that were looked at when the accessor was opened.
    pub fn opening_cost(&self) -> usize {
        self.sparse.as_ref().map_or(1, |sparse| sparse.count)
    }

    fn locate(&self, element: usize) -> Option<(&Span<'_>, usize)> {
        match self.sparse.as_ref().and_then(|sparse| Some((&sparse.values, sparse.position(element)?))) {
            Some(found) => Some(found),
            None => self.dense.as_ref().map(|span| (span, element)),
        }
    }

    /// The first `N` lanes of element `element` (below `count`), integers scaled as `normalized` says.
    pub fn floats<const N: usize>(&self, element: usize) -> [f32; N] {
        let Some((span, element)) = self.locate(element) else { return [0.0; N] };
        let scaled = |value: f32, most: f32| if self.normalized { (value / most).max(-1.0) } else { value };
        std::array::from_fn(|lane| match self.component {
            Component::I8 => scaled(f32::from(i8::from_le_bytes(span.bytes(element, lane))), 127.0),
            Component::U8 => scaled(f32::from(u8::from_le_bytes(span.bytes(element, lane))), 255.0),
            Component::I16 => scaled(f32::from(i16::from_le_bytes(span.bytes(element, lane * 2))), 32767.0),
            Component::U16 => scaled(f32::from(u16::from_le_bytes(span.bytes(element, lane * 2))), 65535.0),
            Component::U32 => u32::from_le_bytes(span.bytes(element, lane * 4)) as f32,
            Component::F32 => f32::from_le_bytes(span.bytes(element, lane * 4)),
        })
    }

    /// The first `N` lanes of each of `elements`.
    pub fn gather<const N: usize>(&self, elements: &[u32]) -> Vec<[f32; N]> {
        match (&self.dense, &self.sparse, self.component) {
            (Some(span), None, Component::F32) if N <= self.lanes => {
                elements.iter().map(|&element| span.floats(element as usize)).collect()
            }
            _ => elements.iter().map(|&element| self.floats(element as usize)).collect(),
        }
    }

    /// The element of an accessor of indices.
    pub fn unsigned(&self, element: usize) -> u32 {
        self.locate(element).map_or(0, |(span, element)| span.unsigned(element, self.component))
    }
}
