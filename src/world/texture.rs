//! Reading textures: from a place on a mesh to the texel, filtered between its neighbours.
//!
//! A pixel's paths lie anywhere in it, so that what a texture shows within a pixel is averaged by them.

use eyebox_scene::texture::{Encoding, Filter, Texels, TextureInput, Wrap};
use eyebox_scene::{Colour, Scalar};
use std::sync::LazyLock;

/// Light of the 256 values of a byte, by the curve of IEC 61966-2-1.
static SRGB: LazyLock<[f64; 256]> = LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f64 / 255.0)));

/// IEC 61966-2-1, 0–1 and beyond.
fn linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The column or row that a whole coordinate means; none outside of a picture that ends in black.
fn wrapped(at: f64, count: usize, wrap: Wrap) -> Option<usize> {
    let size = count as f64;
    // Most are inside; the remainder of a division takes longer than all the rest.
    if (0.0..size).contains(&at) {
        return Some(at as usize);
    }
    let inside = match wrap {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Mirror => {
            let twice = at.rem_euclid(2.0 * size);
            if twice < size { twice } else { 2.0 * size - 1.0 - twice }
        }
        Wrap::Clamp => at.clamp(0.0, size - 1.0),
        Wrap::Black => return None,
    };
    // Rounding may reach the end of a wide picture.
    Some((inside as usize).min(count.saturating_sub(1)))
}

/// Where texture coordinates of the mesh lie in the picture: columns and rows of texels from its upper left corner, and beyond it.
pub fn place(input: &TextureInput, [u, v]: [f64; 2]) -> [f64; 2] {
    let [across, down] = input.to_picture.map(|[a, b, c]| a * u + b * v + c);
    [across * input.texture.width as f64, down * input.texture.height as f64]
}

/// What a parameter reads at texture coordinates of the mesh: red, green, blue, alpha.
pub fn read(input: &TextureInput, uv: [f64; 2]) -> [f64; 4] {
    read_at(input, place(input, uv), input.filter)
}

/// What it reads of one texel, by its whole column and row, in the picture or beyond it.
pub fn read_texel(input: &TextureInput, [column, row]: [f64; 2]) -> [f64; 4] {
    read_at(input, [column + 0.5, row + 0.5], Filter::Nearest)
}

#[inline]
fn read_at(input: &TextureInput, at: [f64; 2], filter: Filter) -> [f64; 4] {
    let at = (at, filter);
    // The kind of texels is asked once, not at each. Alpha is never encoded.
    let found = match (&input.texture.texels, input.encoding) {
        // A scene holds none of these.
        (Texels::Encoded(_), _) | (_, Encoding::OfFile) => [0.0; 4],
        (Texels::Bytes(bytes), Encoding::Srgb) => {
            let table = &*SRGB;
            filtered(input, at, |index| {
                let [r, g, b, a] = bytes.get(index).copied().unwrap_or_default();
                let colour = |byte: u8| table[usize::from(byte)];
                [colour(r), colour(g), colour(b), f64::from(a) / 255.0]
            })
        }
        (Texels::Bytes(bytes), Encoding::Linear) => filtered(input, at, |index| {
            bytes.get(index).copied().unwrap_or_default().map(|byte| f64::from(byte) / 255.0)
        }),
        (Texels::Floats(floats), Encoding::Linear) => {
            filtered(input, at, |index| floats.get(index).copied().unwrap_or_default().map(f64::from))
        }
        (Texels::Floats(floats), Encoding::Srgb) => filtered(input, at, |index| {
            let [r, g, b, a] = floats.get(index).copied().unwrap_or_default().map(f64::from);
            [linear(r), linear(g), linear(b), a]
        }),
    };
    std::array::from_fn(|c| input.channels[c].of(found) * input.scale[c] + input.bias[c])
}

/// Between the texels about a place, in texels.
fn filtered(input: &TextureInput, ([x, y], filter): ([f64; 2], Filter), texel: impl Fn(usize) -> [f64; 4]) -> [f64; 4] {
    if !(x.is_finite() && y.is_finite()) {
        return [0.0; 4];
    }
    let (width, height) = (input.texture.width, input.texture.height);
    let column = |x: f64| wrapped(x, width, input.wrap[0]);
    let row = |y: f64| wrapped(y, height, input.wrap[1]);
    let at = |x: Option<usize>, y: Option<usize>| -> [f64; 4] {
        match (x, y) {
            (Some(x), Some(y)) => texel(y * width + x),
            (None, _) | (_, None) => [0.0; 4],
        }
    };
    match filter {
        Filter::Nearest => at(column(x.floor()), row(y.floor())),
        Filter::Linear => {
            let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
            let (s, t) = (x - 0.5 - left, y - 0.5 - top);
            let (columns, rows) = ([column(left), column(left + 1.0)], [row(top), row(top + 1.0)]);
            let along = |y: Option<usize>| -> [f64; 4] {
                let (a, b) = (at(columns[0], y), at(columns[1], y));
                std::array::from_fn(|c| a[c] + (b[c] - a[c]) * s)
            };
            let (a, b) = (along(rows[0]), along(rows[1]));
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
        }
    }
}

/// Texture coordinates of a place, by set.
pub type Coordinates = [[f64; 2]; 2];

/// The coordinates that an input asks for.
pub fn of_set(input: &TextureInput, uv: &Coordinates) -> [f64; 2] {
    uv[usize::from(input.set > 0)]
}

/// A number of a surface at these texture coordinates.
pub fn scalar_at(scalar: &Scalar, uv: &Coordinates) -> f64 {
    match &scalar.texture {
        None => scalar.factor,
        Some((input, channel)) => scalar.factor * channel.of(read(input, of_set(input, uv))),
    }
}

/// A colour of a surface at these texture coordinates, linear Rec.709.
pub fn colour_at(colour: &Colour, uv: &Coordinates) -> [f64; 3] {
    match &colour.texture {
        None => colour.factor,
        Some(input) => {
            let found = read(input, of_set(input, uv));
            std::array::from_fn(|c| colour.factor[c] * found[c])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::Shared;
    use eyebox_scene::Texture;
    use eyebox_scene::texture::Channel;
    use std::sync::Arc;

    fn input(wrap: Wrap, filter: Filter) -> TextureInput {
        // Red counts the columns, green the rows.
        let texels = (0..6).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.5, 1.0]).collect();
        let texture = Texture { name: "t".into(), width: 3, height: 2, texels: Texels::Floats(Arc::new(texels)) };
        TextureInput {
            texture: Shared::from(texture),
            encoding: Encoding::Linear,
            wrap: [wrap; 2],
            filter,
            set: 0,
            to_picture: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            channels: Channel::ALL,
            scale: [1.0; 4],
            bias: [0.0; 4],
            fallback: None,
        }
    }

    #[test]
    fn texels_lie_from_the_top_left() {
        let input = input(Wrap::Repeat, Filter::Nearest);
        for (u, v, want) in [(0.1, 0.1, [0.0, 0.0]), (0.5, 0.9, [1.0, 1.0]), (0.99, 0.0, [2.0, 0.0])] {
            assert_eq!(read(&input, [u, v])[..2], want);
        }
    }

    #[test]
    fn outside_of_the_picture() {
        let column = |wrap, u: f64| read(&input(wrap, Filter::Nearest), [u, 0.25])[0];
        assert_eq!((column(Wrap::Repeat, 1.1), column(Wrap::Repeat, -0.1)), (0.0, 2.0));
        assert_eq!((column(Wrap::Mirror, 1.1), column(Wrap::Mirror, -0.5), column(Wrap::Mirror, 2.1)), (2.0, 1.0, 0.0));
        assert_eq!((column(Wrap::Clamp, 7.0), column(Wrap::Clamp, -7.0)), (2.0, 0.0));
        assert_eq!(read(&input(Wrap::Black, Filter::Nearest), [1.5, 0.25]), [0.0; 4]);
        assert_eq!(read(&input(Wrap::Repeat, Filter::Linear), [f64::NAN, 0.0]), [0.0; 4]);
        assert!(read(&input(Wrap::Repeat, Filter::Linear), [1e300, -1e300]).iter().all(|x| x.is_finite()));
    }

    #[test]
    fn between_texels() {
        let clamped = input(Wrap::Clamp, Filter::Linear);
        // Centres are at (i + ½)/3.
        for (u, want) in [(0.5 / 3.0, 0.0), (1.0 / 3.0, 0.5), (0.5, 1.0), (1.0, 2.0)] {
            assert!((read(&clamped, [u, 0.25])[0] - want).abs() < 1e-12, "{u}");
        }
        // Round the edge: the last and the first column alike.
        assert!((read(&input(Wrap::Repeat, Filter::Linear), [0.0, 0.25])[0] - 1.0).abs() < 1e-12);
    }

    /// Scale and bias are those of what is read, not of the texel's component.
    #[test]
    fn components_are_picked() {
        let texels = Texels::Floats(Arc::new(vec![[0.1, 0.2, 0.3, 0.4]]));
        let texture = Texture { name: "t".into(), width: 1, height: 1, texels };
        let picked = TextureInput {
            texture: Shared::from(texture),
            channels: [Channel::Alpha, Channel::Red, Channel::Red, Channel::Green],
            scale: [2.0, 1.0, 10.0, 1.0],
            bias: [0.0, 1.0, 0.0, 0.0],
            ..input(Wrap::Repeat, Filter::Nearest)
        };
        let want = [0.8, 1.1, 1.0, 0.2];
        assert!(read(&picked, [0.5, 0.5]).iter().zip(want).all(|(found, want)| (found - want).abs() < 1e-7));
        assert!(!picked.is_grey());
        let grey = TextureInput { channels: [Channel::Blue; 4], scale: [1.0; 4], bias: [0.0; 4], ..picked };
        assert!(grey.is_grey());
    }

    /// IEC 61966-2-1: 188/255 is 0.502886 of white, 10/255 lies on the straight piece.
    #[test]
    fn colours_are_decoded_before_they_are_mixed() {
        let texels = Texels::Bytes(Arc::new(vec![[188, 10, 255, 188]]));
        let texture = Texture { name: "t".into(), width: 1, height: 1, texels };
        let srgb = TextureInput {
            texture: Shared::from(texture),
            encoding: Encoding::Srgb,
            scale: [2.0, 1.0, 1.0, 1.0],
            bias: [0.0, 0.0, -1.0, 0.0],
            ..input(Wrap::Repeat, Filter::Linear)
        };
        let [r, g, b, a] = read(&srgb, [0.3, 0.3]);
        assert!((r - 2.0 * 0.502_886).abs() < 2e-6 && (g - 10.0 / 255.0 / 12.92).abs() < 1e-12, "{r} {g}");
        assert!(b.abs() < 1e-12 && (a - 188.0 / 255.0).abs() < 1e-12);
    }
}
