//! Pictures in tiles (UDIM): each lies in its own unit of texture coordinates, number 1001 + column + 10 · row. They are put
//! together into one picture, since neighbours are filtered into one another.

use eyebox_scene::texture::{Texels, Wrap};
use eyebox_scene::{Texture, TextureInput};
use std::path::PathBuf;
use std::sync::Arc;

/// Columns and rows that tiles take, from those of 1001.
pub(super) fn grid(tiles: &[(PathBuf, [u32; 2])]) -> [u32; 2] {
    tiles.iter().fold([1, 1], |[columns, rows], (_, [column, row])| [columns.max(column + 1), rows.max(row + 1)])
}

/// Reads the whole where one tile was read: (0, 0) to (1, 1) is the tile at the bottom left. Outside of all tiles it is black.
pub(super) fn place(input: &mut TextureInput, [columns, rows]: [u32; 2]) {
    let (columns, rows) = (f64::from(columns), f64::from(rows));
    let [across, [a, b, c]] = input.to_picture;
    // Down from the top of the lowest row, which has all others above it.
    input.to_picture = [across.map(|x| x / columns), [a / rows, b / rows, (c + rows - 1.0) / rows]];
    input.wrap = [Wrap::Black; 2];
}

/// One picture of tiles, all as large as the largest; where there is none it is black. None if it would take more bytes than
/// `most`.
pub(super) fn joined(name: &str, tiles: &[(Texture, [u32; 2])], most: u64) -> Option<Texture> {
    let (width, height) = tiles.iter().fold((1, 1), |(w, h), (tile, _)| (w.max(tile.width), h.max(tile.height)));
    let [columns, rows] = tiles.iter().fold([1, 1], |[c, r], (_, [column, row])| [c.max(column + 1), r.max(row + 1)]);
    let (wide, high) = (width.checked_mul(columns as usize)?, height.checked_mul(rows as usize)?);
    let is_bytes = tiles.iter().all(|(tile, _)| matches!(tile.texels, Texels::Bytes(_)));
    let size = if is_bytes { 4 } else { 16 };
    let count = wide.checked_mul(high)?;
    if u64::try_from(count.checked_mul(size)?).ok()? > most {
        return None;
    }
    let texels = if is_bytes {
        let mut out = vec![[0, 0, 0, 255]; count];
        for (tile, at) in tiles {
            if let Texels::Bytes(texels) = &tile.texels {
                copy(texels, tile, &mut out, [width, height, wide, high], *at);
            }
        }
        Texels::Bytes(Arc::new(out))
    } else {
        let mut out = vec![[0.0, 0.0, 0.0, 1.0]; count];
        for (tile, at) in tiles {
            match &tile.texels {
                Texels::Floats(texels) => copy(texels, tile, &mut out, [width, height, wide, high], *at),
                Texels::Bytes(bytes) => {
                    let texels: Vec<[f32; 4]> = bytes.iter().map(|texel| texel.map(|x| f32::from(x) / 255.0)).collect();
                    copy(&texels, tile, &mut out, [width, height, wide, high], *at);
                }
                Texels::Encoded(_) => {}
            }
        }
        Texels::Floats(Arc::new(out))
    };
    Some(Texture { name: name.to_owned(), width: wide, height: high, texels })
}

/// Puts a tile where it belongs, each texel as often as it takes.
fn copy<T: Copy>(
    texels: &[[T; 4]],
    tile: &Texture,
    out: &mut [[T; 4]],
    [width, height, wide, high]: [usize; 4],
    [column, row]: [u32; 2],
) {
    let (left, top) = (width * column as usize, high - height * (row as usize + 1));
    for y in 0..height {
        let from = tile.width * (y * tile.height / height);
        for x in 0..width {
            let texel = texels.get(from + x * tile.width / width);
            if let (Some(texel), Some(place)) = (texel, out.get_mut((top + y) * wide + left + x)) {
                *place = *texel;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::Shared;
    use eyebox_scene::texture::{Channel, Encoding, Filter};

    /// Each tile has its own grey; the second is twice as large.
    #[test]
    fn tiles_lie_where_their_numbers_say() {
        let tile = |grey: u8, size: usize| Texture {
            name: String::new(),
            width: size,
            height: size,
            texels: Texels::Bytes(Arc::new(vec![[grey, grey, grey, 255]; size * size])),
        };
        let places = [[0, 0], [1, 0], [0, 2]];
        let all = [(tile(51, 2), places[0]), (tile(102, 4), places[1]), (tile(153, 2), places[2])];
        let joined = joined("t", &all, 1 << 20).unwrap();
        assert_eq!((joined.width, joined.height), (8, 12));
        let mut input = TextureInput {
            texture: Shared::from(joined),
            encoding: Encoding::Linear,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Nearest,
            set: 0,
            to_picture: [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]],
            channels: Channel::ALL,
            scale: [1.0; 4],
            bias: [0.0; 4],
            fallback: None,
        };
        let sources: Vec<_> = places.iter().map(|place| (PathBuf::new(), *place)).collect();
        place(&mut input, grid(&sources));
        assert_eq!(input.wrap, [Wrap::Black; 2]);
        let Texels::Bytes(texels) = &input.texture.texels else { panic!("bytes") };
        for (u, v, want) in [(0.5, 0.5, 51), (1.9, 0.1, 102), (0.1, 2.9, 153), (1.5, 1.5, 0)] {
            let [across, down] = input.to_picture.map(|[a, b, c]| a * u + b * v + c);
            assert_eq!(texels[(down * 12.0) as usize * 8 + (across * 8.0) as usize][0], want, "{u} {v}");
        }
        // Above the highest row.
        assert!(input.to_picture[1][1] * 3.5 + input.to_picture[1][2] < 0.0);
        assert!(super::joined("t", &all, 100).is_none());
    }
}
