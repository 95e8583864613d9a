//! The page around its data. Texts of a file reach it as JSON inside a block that is never run, and as the title; a policy lets
//! nothing run or load but what carries the page's own number.

use serde_json::Value;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const SCRIPTS: [&str; 8] = [
    include_str!("data.js"),
    include_str!("mix.js"),
    include_str!("show.js"),
    include_str!("controls.js"),
    include_str!("tables.js"),
    include_str!("plot.js"),
    include_str!("selftest.js"),
    include_str!("start.js"),
];

/// The whole page. `more`: a section of our own making, in which texts of files are escaped.
pub fn page(title: &str, data: &Value, more: &str) -> String {
    let json = in_script(&data.to_string());
    // The hash of what a file brings cannot stand in it.
    let nonce = blake3::hash(format!("{title}\0{json}\0{more}").as_bytes()).to_hex();
    let (script, title) = (SCRIPTS.join("\n"), in_html(title));
    fill(TEMPLATE, |name| match name {
        "nonce" => nonce.as_str(),
        "title" => &title,
        "style" => STYLE.trim_end(),
        "script" => script.trim_end(),
        "data" => &json,
        "more" => more,
        _ => "",
    })
}

/// Replaces `{{name}}` once; what is put in is not looked at again.
fn fill<'v>(template: &str, value: impl Fn(&str) -> &'v str) -> String {
    let mut parts = template.split("{{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").unwrap_or(("", part));
        out.push_str(value(name));
        out.push_str(rest);
    }
    out
}

/// JSON that can stand in a script block: `<` could end it or begin a comment. HTML Standard, "Restrictions for contents of
/// script elements".
fn in_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for letter in json.chars() {
        match letter {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", u32::from(letter))),
            _ => out.push(letter),
        }
    }
    out
}

/// A text between tags or in a quoted attribute.
fn in_html(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_cannot_break_out() {
        let hostile = "</script><img src=x onerror=alert(1)>\u{2028}<!--{{script}}";
        let page = page(hostile, &serde_json::json!({ "name": hostile, "{{data}}": 1 }), "");
        assert!(!page.contains("<img") && !page.contains("<!--"), "{}", &page[..2000]);
        assert!(page.contains("&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;"));
        // One block of data, one of code.
        assert_eq!(page.matches("</script>").count(), 2);
        assert_eq!(page.matches("\"use strict\"").count(), 1, "{{{{script}}}} in a name is not filled in");
        let data = page.split("id=\"frame\">").nth(1).unwrap().split("</script>").next().unwrap();
        let back: Value = serde_json::from_str(data).unwrap();
        assert_eq!(back["name"], hostile);
    }

    #[test]
    fn nothing_is_loaded_and_no_text_becomes_markup() {
        let page = page("t", &serde_json::json!({}), "");
        for loads in
            ["http://", "https://", "src=", "@import", "url(", "<link", "import(", "XMLHttpRequest", "WebSocket"]
        {
            assert!(!page.contains(loads), "{loads}");
        }
        for markup in
            ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "Function(", "DOMParser"]
        {
            assert!(!page.contains(markup), "{markup}");
        }
        assert!(page.contains("default-src 'none'; script-src 'nonce-"));
        assert!(!page.contains("unsafe"));
        assert!(!page.contains("{{"));
    }
}
