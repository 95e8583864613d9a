//! Pictures that were made elsewhere, as light: skies, slides and plates. What a file says of its windows and its colours is
//! honoured, and what was made of it is said.

use super::colours::file_space;
use super::exr::{About, COLOR_INTEROP_ID, WHITE_LUMINANCE, decode_all};
use super::frame::Frame;
use super::jpeg::is_cut_short;
use super::names;
use eyebox_base::colour::FileSpace;
use eyebox_base::error::nearest_name;

/// More pixels than this are a broken header, not a picture: 16384 × 8192.
pub(super) const MAX_PIXELS: usize = 1 << 27;
/// Bytes that all channels of an EXR may take once they are decoded, as f32: a few bytes can be zeros for ever.
const MAX_DECODED: usize = 1 << 33;
/// What is said of a JPEG that ends before its picture does.
pub const CUT_SHORT: &str = "it is cut short: a part of the picture is missing";
/// A display window of so many pixels is believed however small the data window is; and so many times that.
const ALWAYS_SHOWN: usize = 1 << 24;
const MOST_AROUND: usize = 64;

/// A picture in linear Rec.709, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    pub width: usize,
    pub height: usize,
    pub light: Light,
    /// cd/m² of the value (1, 1, 1), if the file says so.
    pub white_cd_m2: Option<f64>,
    pub remarks: Vec<Remark>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// Luminance.
    Grey(Vec<f32>),
    Rgb(Vec<[f32; 3]>),
}

/// What was made of a file, in a sentence that goes on from its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// It is likely not what was meant.
    pub warns: bool,
    pub text: String,
}

impl Remark {
    pub(super) fn info(text: impl Into<String>) -> Remark {
        Remark { warns: false, text: text.into() }
    }
    fn warning(text: impl Into<String>) -> Remark {
        Remark { warns: true, text: text.into() }
    }
}

impl Still {
    /// The picture of an EXR file: its default image, its only picture or the layer that is asked for, as its display window
    /// shows it. Errors: what is wrong with the file, or which layers it has.
    pub fn of_exr(bytes: &[u8], layer: Option<&str>) -> Result<Still, String> {
        check_size(bytes)?;
        let (frame, about) = decode_all(bytes)?;
        let mut remarks = Vec::new();
        if about.is_cube {
            return Err("it is a cube map by its `envmap`; expected latitudes and longitudes".to_owned());
        }
        let layer = chosen(&frame, layer, &mut remarks)?;
        let Some([red, green, blue]) = colours(&frame, &layer) else { return Err("it has no picture".to_owned()) };
        for (component, data) in [("R", red), ("G", green), ("B", blue)] {
            if let Some(pixel) = data.iter().position(|value| !value.is_finite()) {
                let (x, y) = (pixel % frame.width.max(1), pixel / frame.width.max(1));
                let value = data.get(pixel).copied().unwrap_or(f32::NAN);
                return Err(format!("{component} of pixel ({x}, {y}) is {value}; expected finite values"));
            }
        }
        let window = Window::of(&frame, &about)?;
        remarks.extend(window.remark());
        let grey = std::ptr::eq(red, green);
        let light = if grey {
            Light::Grey(window.cut(|pixel| red.get(pixel).copied().unwrap_or(0.0)))
        } else {
            let space = space(&frame, &about, &mut remarks);
            let at = |data: &[f32], pixel: usize| f64::from(data.get(pixel).copied().unwrap_or(0.0));
            Light::Rgb(window.cut(|pixel| {
                let stored = [red, green, blue];
                if space.is_linear_rec709() {
                    return stored.map(|data| data.get(pixel).copied().unwrap_or(0.0));
                }
                space.to_rec709(stored.map(|data| at(data, pixel))).map(|value| value as f32)
            }))
        };
        let white = frame.number(WHITE_LUMINANCE).filter(|white| *white > 0.0 && white.is_finite());
        Ok(Still { width: window.width, height: window.height, light, white_cd_m2: white, remarks })
    }

    /// A PNG or JPEG, whose values are taken as sRGB. Errors: what is wrong with the file.
    pub fn of_srgb(bytes: &[u8]) -> Result<Still, String> {
        // Other formats that the decoder knows, Radiance HDR among them, hold linear values.
        let format = image::guess_format(bytes).map_err(|error| error.to_string())?;
        if !matches!(format, image::ImageFormat::Png | image::ImageFormat::Jpeg) {
            return Err(format!("it is {}", format.extensions_str().first().unwrap_or(&"of another format")));
        }
        let decoded =
            image::load_from_memory_with_format(bytes, format).map_err(|error| undecoded(&error, bytes, format))?;
        if format == image::ImageFormat::Jpeg && is_cut_short(bytes) {
            return Err(CUT_SHORT.to_owned());
        }
        let (width, height) = (decoded.width() as usize, decoded.height() as usize);
        let linear =
            |pixel: &image::Rgb<f32>| FileSpace::SRGB.to_rec709(pixel.0.map(f64::from)).map(|value| value as f32);
        let mut remarks = vec![Remark::info("has no linear values: they are taken as sRGB")];
        if decoded.color().has_alpha() {
            remarks.push(Remark::warning("has an alpha channel, which is left out"));
        }
        let light = Light::Rgb(decoded.to_rgb32f().pixels().map(linear).collect());
        Ok(Still { width, height, light, white_cd_m2: None, remarks })
    }
}

/// Whether [`Still::of_srgb`] is for a file of this beginning.
pub fn is_srgb(bytes: &[u8]) -> bool {
    matches!(image::guess_format(bytes), Ok(image::ImageFormat::Png | image::ImageFormat::Jpeg))
}

/// Why a picture could not be decoded: what it claims, where that is more than is allowed.
pub fn undecoded(error: &image::ImageError, bytes: &[u8], format: image::ImageFormat) -> String {
    let size = || image::ImageReader::with_format(std::io::Cursor::new(bytes), format).into_dimensions().ok();
    match (error, size()) {
        (image::ImageError::Limits(_), Some((width, height))) => {
            format!("it claims {width} × {height} pixels, more than a picture may have")
        }
        (image::ImageError::Limits(_), None) => "it claims more pixels than a picture may have".to_owned(),
        _ => error.to_string(),
    }
}

/// Errors: a size that an EXR claims and no picture has. What else is wrong with the header its decoder says.
fn check_size(bytes: &[u8]) -> Result<(), String> {
    let Ok(meta) = ::exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false) else { return Ok(()) };
    let mut decoded = 0usize;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.0, header.layer_size.1);
        let area = width.checked_mul(height).filter(|area| *area <= MAX_PIXELS);
        let all = area.and_then(|area| area.checked_mul(header.channels.list.len() * size_of::<f32>()));
        decoded = match all.and_then(|all| decoded.checked_add(all)) {
            Some(decoded) if decoded <= MAX_DECODED => decoded,
            Some(_) | None => {
                return Err(format!("it claims {width} × {height} pixels, more than a picture may have"));
            }
        };
    }
    Ok(())
}

/// Red, green and blue of a layer, also where they are called by small letters or by their names.
fn colours<'f>(frame: &'f Frame, layer: &str) -> Option<[&'f [f32]; 3]> {
    const OTHERS: [[&str; 3]; 2] = [["r", "g", "b"], ["red", "green", "blue"]];
    let spelt = |names: &[&str; 3]| {
        let [r, g, b] = names.map(|name| frame.component(layer, name).map(|channel| channel.data.as_slice()));
        Some([r?, g?, b?])
    };
    frame.rgb(layer).or_else(|| OTHERS.iter().find_map(spelt))
}

/// The layer whose picture is meant; the empty name is the default image. Errors: none, or several, in words.
fn chosen(frame: &Frame, asked: Option<&str>, remarks: &mut Vec<Remark>) -> Result<String, String> {
    let pictures: Vec<&str> = frame.layer_names().into_iter().filter(|name| colours(frame, name).is_some()).collect();
    let named = || {
        let called = |name: &&str| if name.is_empty() { "the default image".to_owned() } else { format!("`{name}`") };
        let all: Vec<String> = pictures.iter().map(called).collect();
        if all.is_empty() {
            let channels: Vec<&str> = frame.channels.iter().map(|channel| channel.name.as_str()).collect();
            format!("its channels are {}; expected Y, or R, G and B", channels.join(", "))
        } else {
            format!("its pictures are {}", all.join(", "))
        }
    };
    if let Some(asked) = asked {
        let exact = pictures.iter().find(|name| **name == asked);
        // `Combined` for `ViewLayer.Combined`, where only one ends so.
        let ends = |name: &&&str| name.rsplit('.').next() == Some(asked);
        let mut short = pictures.iter().filter(ends);
        let one = short.next().filter(|_| short.next().is_none());
        return match exact.or(one) {
            Some(name) => Ok((*name).to_owned()),
            None => {
                let near = nearest_name(asked, pictures.iter().copied());
                let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
                Err(format!("it has no layer `{asked}`: {}{near}", named()))
            }
        };
    }
    let light: Vec<&&str> = pictures.iter().filter(|name| !names::is_error(name)).collect();
    match light.as_slice() {
        _ if pictures.contains(&"") => Ok(String::new()),
        [only] => {
            remarks.push(Remark::info(format!("has no default image: its layer `{only}` is taken")));
            Ok((**only).to_owned())
        }
        [] => Err(named()),
        [..] => Err(format!("it has no default image: say which layer is meant; {}", named())),
    }
}

/// How the colours are to be read, and what is to be said of it.
fn space(frame: &Frame, about: &About, remarks: &mut Vec<Remark>) -> FileSpace {
    let own = about.chromaticities.as_ref();
    let by_primaries = own.and_then(FileSpace::linear);
    if let (Some(_), None) = (own, by_primaries) {
        remarks.push(Remark::warning("has `chromaticities` that span no colours: they are left out"));
    }
    let found = file_space(frame);
    let by = match frame.text(COLOR_INTEROP_ID) {
        None => "`chromaticities`".to_owned(),
        Some(id) => match FileSpace::of_interop_id(id) {
            Some(_) => format!("`{COLOR_INTEROP_ID}` {id}"),
            None => {
                let taken =
                    if by_primaries.is_some() { "its `chromaticities` count" } else { "taken as linear Rec.709" };
                remarks.push(Remark::warning(format!("has the unknown `{COLOR_INTEROP_ID}` {id}: {taken}")));
                "`chromaticities`".to_owned()
            }
        },
    };
    if !found.is_linear_rec709() {
        remarks.push(Remark::info(format!("is converted to linear Rec.709 by its {by}")));
    }
    found
}

/// The display window over the data that are there.
struct Window {
    left: i64,
    top: i64,
    width: usize,
    height: usize,
    /// Of the data window.
    data: [usize; 2],
}

impl Window {
    fn of(frame: &Frame, about: &About) -> Result<Window, String> {
        let [left, top, width, height] = about.display;
        let data = [frame.width, frame.height];
        let size = [width, height].map(|n| usize::try_from(n).unwrap_or(0));
        let most = (data[0] * data[1]).saturating_mul(MOST_AROUND).clamp(ALWAYS_SHOWN, MAX_PIXELS);
        match size[0].checked_mul(size[1]) {
            Some(pixels) if pixels > 0 && pixels <= most => {
                Ok(Window { left, top, width: size[0], height: size[1], data })
            }
            Some(_) | None => Err(format!(
                "its display window of {width} × {height} pixels is none for data of {} × {}",
                data[0], data[1]
            )),
        }
    }

    /// The values of the data as the display window shows them; black where there are none.
    fn cut<T: Default + Clone>(&self, at: impl Fn(usize) -> T) -> Vec<T> {
        let mut out = vec![T::default(); self.width * self.height];
        for (y, row) in out.chunks_mut(self.width).enumerate() {
            let Some(from_y) = inside(self.top, y, self.data[1]) else { continue };
            for (x, value) in row.iter_mut().enumerate() {
                if let Some(from_x) = inside(self.left, x, self.data[0]) {
                    *value = at(from_y * self.data[0] + from_x);
                }
            }
        }
        out
    }

    fn remark(&self) -> Option<Remark> {
        let covered = |first: i64, size: usize, data: usize| {
            first >= 0 && first.checked_add_unsigned(size as u64).is_some_and(|end| end <= data as i64)
        };
        let whole = covered(self.left, self.width, self.data[0]) && covered(self.top, self.height, self.data[1]);
        let said = format!(
            "has data of {} × {} pixels for a display window of {} × {}",
            self.data[0], self.data[1], self.width, self.height
        );
        if !whole {
            return Some(Remark::warning(format!("{said}: black where there are none")));
        }
        ([self.width, self.height] != self.data).then(|| Remark::info(format!("{said}: the overscan is cut off")))
    }
}

/// The index in the data of the nth pixel of a window that begins `first` pixels after them.
fn inside(first: i64, n: usize, data: usize) -> Option<usize> {
    let at = first.checked_add(i64::try_from(n).ok()?)?;
    usize::try_from(at).ok().filter(|at| *at < data)
}

#[cfg(test)]
#[path = "still_tests.rs"]
mod tests;
