//! XML, as far as MaterialX' files need it: elements and their attributes. Text between elements says nothing there.
//! Source: XML 1.0, fifth edition.

/// An element with what is in it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }
    /// The children of this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| child.name == name)
    }
}

/// Elements in one another.
const MOST_DEEP: usize = 64;

/// The outermost element.
///
/// # Errors
/// What is no XML, with its line. Document types, whose entities may grow without bound.
pub(super) fn parse(text: &str) -> Result<Element, String> {
    let mut parser = Parser { text, at: 0 };
    parser.document().map_err(|what| {
        let line = 1 + text.get(..parser.at).unwrap_or(text).matches('\n').count();
        format!("line {line}: {what}")
    })
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// Goes behind `end`, which must come; what is before it.
    fn until(&mut self, end: &str) -> Result<&'a str, String> {
        let rest = self.rest();
        let length = rest.find(end).ok_or_else(|| format!("no `{end}` follows"))?;
        self.at += length + end.len();
        Ok(rest.get(..length).unwrap_or_default())
    }

    fn document(&mut self) -> Result<Element, String> {
        // The last is the innermost that is open.
        let mut open: Vec<Element> = Vec::new();
        loop {
            let Some(start) = self.rest().find('<') else {
                return Err(match open.last() {
                    Some(element) => format!("the element `{}` is not closed", element.name),
                    None => "there is no element".to_owned(),
                });
            };
            self.at += start;
            let rest = self.rest();
            if rest.starts_with("<!--") {
                self.until("-->")?;
            } else if rest.starts_with("<?") {
                self.until("?>")?;
            } else if rest.starts_with("<![CDATA[") {
                self.until("]]>")?;
            } else if rest.starts_with("<!") {
                return Err("a document type, which is not read".to_owned());
            } else if rest.starts_with("</") {
                self.at += 2;
                let name = self.until(">")?.trim();
                let closed = open.pop().filter(|element| element.name == name);
                let closed = closed.ok_or_else(|| format!("`</{name}>` closes nothing that is open"))?;
                match open.last_mut() {
                    Some(outer) => outer.children.push(closed),
                    None => return Ok(closed),
                }
            } else {
                self.at += 1;
                let (element, is_empty) = self.tag()?;
                match open.last_mut() {
                    _ if !is_empty => open.push(element),
                    Some(outer) => outer.children.push(element),
                    None => return Ok(element),
                }
                if open.len() > MOST_DEEP {
                    return Err(format!("more than {MOST_DEEP} elements in one another"));
                }
            }
        }
    }

    /// A tag behind its `<`, and whether it is closed at once.
    fn tag(&mut self) -> Result<(Element, bool), String> {
        let mut element = Element { name: self.name()?, ..Element::default() };
        loop {
            self.space();
            let rest = self.rest();
            if rest.starts_with("/>") {
                self.at += 2;
                return Ok((element, true));
            }
            if rest.starts_with('>') {
                self.at += 1;
                return Ok((element, false));
            }
            let name = self.name()?;
            self.space();
            if !self.rest().starts_with('=') {
                return Err(format!("the attribute `{name}` has no value"));
            }
            self.at += 1;
            self.space();
            let quote = match self.rest().chars().next() {
                Some(quote @ ('"' | '\'')) => quote,
                Some(_) | None => return Err(format!("the value of `{name}` is not quoted")),
            };
            self.at += 1;
            let value = unescaped(self.until(quote.encode_utf8(&mut [0; 4]))?)?;
            element.attributes.push((name, value));
        }
    }

    fn space(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn name(&mut self) -> Result<String, String> {
        let rest = self.rest();
        let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | ':' | '-' | '.');
        let length = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        if length == 0 {
            return Err("a name is missing".to_owned());
        }
        self.at += length;
        Ok(rest.get(..length).unwrap_or_default().to_owned())
    }
}

/// With what references stand for.
fn unescaped(text: &str) -> Result<String, String> {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('&') {
        out.push_str(before);
        let (name, behind) = after.split_once(';').ok_or("a `&` without `;`")?;
        let number = |digits: &str, radix: u32| u32::from_str_radix(digits, radix).ok().and_then(char::from_u32);
        let found = match name {
            "lt" => Some('<'),
            "gt" => Some('>'),
            "amp" => Some('&'),
            "quot" => Some('"'),
            "apos" => Some('\''),
            other => match (other.strip_prefix("#x"), other.strip_prefix('#')) {
                (Some(hex), _) => number(hex, 16),
                (None, Some(digits)) => number(digits, 10),
                (None, None) => None,
            },
        };
        out.push(found.ok_or_else(|| format!("the reference `&{name};` is not known"))?);
        rest = behind;
    }
    out.push_str(rest);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn elements_have_attributes_and_children() {
        let found = parse(
            "<?xml version=\"1.0\"?>\n<!-- <no> -->\n<a x = \"1 &lt; &#x41;&#66;\" y='\"'>text<b/><c:d>\n</c:d ><b z=\"\"/></a>",
        );
        let found = found.unwrap();
        assert_eq!(
            (found.name.as_str(), found.attribute("x"), found.attribute("y")),
            ("a", Some("1 < AB"), Some("\""))
        );
        assert_eq!(found.children.iter().map(|child| child.name.as_str()).collect::<Vec<_>>(), ["b", "c:d", "b"]);
        assert_eq!(found.all("b").nth(1).and_then(|b| b.attribute("z")), Some(""));
    }

    #[test]
    fn what_is_no_xml_is_said_with_its_line() {
        let deep = "<a>".repeat(100);
        for (text, want) in [
            ("", "there is no element"),
            ("<a>\n<b>\n", "line 2: the element `b` is not closed"),
            ("<a>\n</b>", "line 2: `</b>` closes nothing"),
            ("<a x/>", "has no value"),
            ("<a x=1/>", "is not quoted"),
            ("<a x=\"&no;\"/>", "`&no;` is not known"),
            ("<!DOCTYPE a []><a/>", "a document type"),
            (deep.as_str(), "more than 64"),
            ("<a x=\"1", "no `\"` follows"),
            ("<", "a name is missing"),
        ] {
            let fault = parse(text).unwrap_err();
            assert!(fault.contains(want) && !fault.contains('\n'), "{text}: {fault}");
        }
    }
}
