//! Where in the text of a USD layer a prim or property stands: `def Xform "hud" { … }`. Only names and nesting are read,
//! so a broken layer is followed as far as its braces go.

/// Byte offset of the specifier of the prim (`/hud/LENS_01`), or of its property (`/hud/LENS_01.xformOpOrder`).
pub fn find(text: &[u8], path: &str) -> Option<usize> {
    let slash = path.rfind('/')?;
    let (prim, property) = match path[slash..].split_once('.') {
        Some((name, property)) => (&path[..slash + name.len()], Some(property)),
        None => (path, None),
    };
    let want: Vec<&str> = prim.split('/').skip(1).collect();
    let mut scan = Scan { text, at: 0 };
    // Names of the prims that are open; an empty one for what is none (a set of variants).
    let mut open: Vec<Vec<u8>> = Vec::new();
    let (mut pending, mut specifier) = (None::<Vec<u8>>, None::<usize>);
    let mut parens = 0usize;
    while let Some(token) = scan.next() {
        match token {
            Token::Open(b'(') => parens += 1,
            Token::Close(b')') => parens = parens.saturating_sub(1),
            Token::Open(b'{') if parens == 0 => {
                open.push(pending.take().unwrap_or_default());
                specifier = None;
            }
            Token::Close(b'}') if parens == 0 => drop(open.pop()),
            Token::Open(_) | Token::Close(_) => {}
            Token::Word(word, at) if parens == 0 => {
                if matches!(word, b"def" | b"over" | b"class") {
                    specifier = Some(at);
                } else if property.is_some_and(|property| property.as_bytes() == word) && is(&open, &want) {
                    return Some(at);
                }
            }
            Token::Word(..) => {}
            Token::Text(name) if parens == 0 => {
                if let Some(at) = specifier {
                    if property.is_none()
                        && want.last().is_some_and(|last| last.as_bytes() == name)
                        && is(&open, &want[..want.len() - 1])
                    {
                        return Some(at);
                    }
                    pending = Some(name.to_vec());
                }
            }
            Token::Text(_) => {}
        }
    }
    None
}

/// Whether the open prims are these; variants' braces count for nothing.
fn is(open: &[Vec<u8>], want: &[&str]) -> bool {
    let named: Vec<&[u8]> = open.iter().map(Vec::as_slice).filter(|name| !name.is_empty()).collect();
    named.len() == want.len() && named.iter().zip(want).all(|(a, b)| *a == b.as_bytes())
}

enum Token<'t> {
    Open(u8),
    Close(u8),
    Word(&'t [u8], usize),
    Text(&'t [u8]),
}

struct Scan<'t> {
    text: &'t [u8],
    at: usize,
}

impl<'t> Scan<'t> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn next(&mut self) -> Option<Token<'t>> {
        loop {
            let start = self.at;
            let byte = self.peek()?;
            self.at += 1;
            match byte {
                b'#' => self.past(b"\n"),
                b'@' => self.past(b"@"),
                b'"' | b'\'' => return Some(Token::Text(self.quoted(byte))),
                b'(' | b'{' => return Some(Token::Open(byte)),
                b')' | b'}' => return Some(Token::Close(byte)),
                _ if is_word(byte) => {
                    while self.peek().is_some_and(is_word) {
                        self.at += 1;
                    }
                    return Some(Token::Word(self.text.get(start..self.at)?, start));
                }
                _ => {}
            }
        }
    }

    /// Past the next `end`, or to the end of the text.
    fn past(&mut self, end: &[u8]) {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let found = rest.windows(end.len()).position(|window| window == end);
        self.at = found.map_or(self.text.len(), |found| self.at + found + end.len());
    }

    /// What stands between quotes, single or triple ones.
    fn quoted(&mut self, quote: u8) -> &'t [u8] {
        if self.text.get(self.at..self.at + 2) == Some(&[quote; 2]) {
            self.at += 2;
            let start = self.at;
            self.past(&[quote; 3]);
            return self.text.get(start..self.at.saturating_sub(3)).unwrap_or_default();
        }
        let start = self.at;
        while let Some(byte) = self.peek().filter(|byte| *byte != quote && *byte != b'\n') {
            self.at += if byte == b'\\' { 2 } else { 1 };
        }
        let found = self.text.get(start..self.at.min(self.text.len())).unwrap_or_default();
        self.at += 1;
        found
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte == b':' || byte >= 0x80
}

#[cfg(test)]
mod tests {
    use super::find;
    use proptest::prelude::*;

    const LAYER: &str = r#"#usda 1.0
(
    defaultPrim = "hud"
    customLayerData = { string def = "hud" }
)
# def Xform "hud" in a comment
def Xform "hud" (
    prepend references = @parts/{lens}.usda@</hud>
)
{
    string note = """def Mesh "LENS" { """
    def Mesh "LENS" ( doc = "a { brace" )
    {
        point3f[] points = [(0, 0, 0)]
        uniform token[] xformOpOrder = []
    }
    variantSet "look" = {
        "black" {
            over "LENS"
            {
                double eyebox:priority = 3
            }
            def Mesh "RIM" { }
        }
    }
}
"#;

    fn line(path: &str) -> Option<usize> {
        find(LAYER.as_bytes(), path).map(|offset| LAYER[..offset].matches('\n').count() + 1)
    }

    #[test]
    fn prims_and_properties_by_their_lines() {
        assert_eq!(line("/hud"), Some(7));
        assert_eq!(line("/hud/LENS"), Some(12));
        assert_eq!(line("/hud/LENS.xformOpOrder"), Some(15));
        assert_eq!(line("/hud/LENS.eyebox:priority"), Some(21));
        assert_eq!(line("/hud/RIM"), Some(23));
        assert_eq!((line("/LENS"), line("/hud/LENS/RIM"), line("hud"), line("/hud.nothing")), (None, None, None, None));
    }

    proptest! {
        #[test]
        fn never_panics(text in "[a-c\"'{}()#@\\\\\n./ def]{0,80}", path in "(/[a-c]){0,3}(\\.[a-c])?") {
            let _ = find(text.as_bytes(), &path);
        }
    }
}
