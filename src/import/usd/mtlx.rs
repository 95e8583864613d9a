//! MaterialX' own files (`.mtlx`) as layers: each material under `/MaterialX/Materials` with the nodes that it reaches, as
//! USD's plugin for MaterialX lays them out. Source: the MaterialX Specification 1.39; the paths are those of UsdMtlx.

use super::xml::Element;
use eyebox_base::colour::FileSpace;
use std::collections::HashSet;
use std::fmt::Write;

/// Nodes of one material, and bytes of a layer; honest ones stay far below.
const MOST_NODES: usize = 10_000;
const MOST_BYTES: usize = 64 << 20;

/// The text of the layer.
///
/// # Errors
/// What is no MaterialX; what would grow without bound.
pub(super) fn layer(root: &Element) -> Result<String, String> {
    if root.name != "materialx" {
        return Err(format!("the outermost element is `{}`, not `materialx`", root.name));
    }
    let mut out =
        "#usda 1.0\n(\n    defaultPrim = \"MaterialX\"\n)\ndef \"MaterialX\" {\ndef Scope \"Materials\" {\n".to_owned();
    for material in root.all("surfacematerial") {
        Writer { root, out: &mut out }.material(material)?;
        if out.len() > MOST_BYTES {
            return Err(format!("its materials become more than {MOST_BYTES} bytes"));
        }
    }
    out += "}\n}\n";
    Ok(out)
}

/// What of the file holds for an element: of attributes that are inherited, the nearest counts.
#[derive(Debug, Clone, Copy)]
struct Scope<'a> {
    colorspace: Option<&'a str>,
}

struct Writer<'a, 'o> {
    root: &'a Element,
    out: &'o mut String,
}

impl<'a> Writer<'a, '_> {
    fn material(&mut self, material: &'a Element) -> Result<(), String> {
        let name = identifier(material)?;
        let path = format!("/MaterialX/Materials/{name}");
        let shader = material.all("input").find(|input| input.attribute("name") == Some("surfaceshader"));
        let _ = writeln!(self.out, "def Material \"{name}\" {{");
        // Names at the file's own level, in the order in which they are met.
        let mut queue: Vec<&str> = Vec::new();
        if let Some(shader) = shader {
            let source = source(shader, &path, &path, None);
            if let Some(source) = source {
                let _ = writeln!(self.out, "token outputs:mtlx:surface.connect = <{source}>");
            }
            queue.extend(shader.attribute("nodename").or(shader.attribute("nodegraph")));
        }
        let mut met: HashSet<&str> = queue.iter().copied().collect();
        while let Some(wanted) = queue.pop() {
            if met.len() > MOST_NODES {
                return Err(format!("the material `{name}` has more than {MOST_NODES} nodes"));
            }
            let Some(found) = self.root.children.iter().find(|child| child.attribute("name") == Some(wanted)) else {
                continue;
            };
            let scope = Scope { colorspace: found.attribute("colorspace").or(self.root.attribute("colorspace")) };
            if found.name == "nodegraph" {
                self.graph(found, &path, scope)?;
            } else {
                self.node(found, &path, &path, None, scope)?;
            }
            let inputs = found.children.iter().flat_map(|child| std::iter::once(child).chain(&child.children));
            for next in inputs.filter(|input| input.name == "input") {
                // Within a graph, names of nodes are its own.
                let outer = if found.name == "nodegraph" { None } else { next.attribute("nodename") };
                queue.extend(outer.or(next.attribute("nodegraph")).filter(|next| met.insert(next)));
            }
        }
        *self.out += "}\n";
        Ok(())
    }

    fn graph(&mut self, graph: &'a Element, material: &str, scope: Scope<'a>) -> Result<(), String> {
        let name = identifier(graph)?;
        let path = format!("{material}/{name}");
        let _ = writeln!(self.out, "def NodeGraph \"{name}\" {{");
        for child in &graph.children {
            match child.name.as_str() {
                "input" => self.input(child, material, material, None, scope, "", graph)?,
                "output" => {
                    if let (Some(source), Some(usd)) = (source(child, &path, material, Some(&path)), usd_type(child)) {
                        let own = identifier(child)?;
                        let _ = writeln!(self.out, "{usd} outputs:{own}.connect = <{source}>");
                    }
                }
                _ => {
                    let scope = Scope { colorspace: child.attribute("colorspace").or(scope.colorspace) };
                    self.node(child, &path, material, Some(graph), scope)?;
                }
            }
        }
        *self.out += "}\n";
        Ok(())
    }

    /// A node at `path`, of `graph` or of the material itself.
    fn node(
        &mut self,
        node: &'a Element,
        path: &str,
        material: &str,
        graph: Option<&'a Element>,
        scope: Scope<'a>,
    ) -> Result<(), String> {
        let (Some(_), Some(own)) = (node.attribute("name"), node.attribute("type")) else { return Ok(()) };
        let name = identifier(node)?;
        let id = match node.attribute("nodedef") {
            Some(named) => named.to_owned(),
            None => definition(node, own),
        };
        let id = quoted(&id);
        let _ = writeln!(self.out, "def Shader \"{name}\" {{\nuniform token info:id = {id}");
        let prefix: String = [Some(self.root), graph, Some(node)]
            .into_iter()
            .flatten()
            .filter_map(|e| e.attribute("fileprefix"))
            .collect();
        for input in node.all("input") {
            self.input(input, path, material, graph.map(|_| path), scope, &prefix, node)?;
        }
        *self.out += "}\n";
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "what an input may refer to")]
    fn input(
        &mut self,
        input: &Element,
        path: &str,
        material: &str,
        graph: Option<&str>,
        scope: Scope<'_>,
        prefix: &str,
        owner: &Element,
    ) -> Result<(), String> {
        let Some(usd) = usd_type(input) else { return Ok(()) };
        let name = identifier(input)?;
        if let Some(source) = source(input, path, material, graph) {
            let _ = writeln!(self.out, "{usd} inputs:{name}.connect = <{source}>");
            return Ok(());
        }
        let Some(value) = input.attribute("value") else { return Ok(()) };
        let space = input.attribute("colorspace").or(scope.colorspace);
        match usd {
            "asset" => {
                let file = format!("{prefix}{}", value.trim()).replace('@', "");
                let _ = write!(self.out, "asset inputs:{name} = @{file}@");
                // Numbers have no colour space, whatever the file around them says.
                let colour = owner.attribute("type").is_some_and(|own| own.starts_with("color"));
                match space.filter(|_| colour || input.attribute("colorspace").is_some()) {
                    Some(space) => writeln!(self.out, " (colorSpace = {})", quoted(space)),
                    None => writeln!(self.out),
                }
                .map_err(|error| error.to_string())?;
            }
            "string" => {
                let _ = writeln!(self.out, "string inputs:{name} = {}", quoted(value));
            }
            "bool" => {
                let _ = writeln!(self.out, "bool inputs:{name} = {}", u8::from(value.trim() == "true"));
            }
            "token" => {}
            _ => {
                let mut numbers = numbers(value).ok_or_else(|| format!("`{name}` has the value `{value}`"))?;
                if usd.starts_with("color")
                    && let Some(space) = space.and_then(file_space)
                    && let Some(rgb) = numbers.first_chunk_mut::<3>()
                {
                    *rgb = space.to_rec709(*rgb);
                }
                let unit = input.attribute("unit").and_then(metres).unwrap_or(1.0);
                if name.starts_with("realworld") {
                    numbers.iter_mut().for_each(|x| *x *= unit);
                }
                let wanted = lanes(usd);
                if numbers.len() != wanted {
                    return Err(format!("`{name}` has {} numbers where its type has {wanted}", numbers.len()));
                }
                let joined = numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
                let _ = match wanted {
                    1 => writeln!(self.out, "{usd} inputs:{name} = {joined}"),
                    _ => writeln!(self.out, "{usd} inputs:{name} = ({joined})"),
                };
            }
        }
        Ok(())
    }
}

/// Where an input or output is connected to: a node beside it, a graph of the material, or an input of the graph around it.
fn source(input: &Element, path: &str, material: &str, graph: Option<&str>) -> Option<String> {
    let output = plain(input.attribute("output").unwrap_or("out"));
    if let Some(node) = input.attribute("nodename") {
        return Some(format!("{path}/{}.outputs:{output}", plain(node)));
    }
    if let Some(other) = input.attribute("nodegraph") {
        return Some(format!("{material}/{}.outputs:{output}", plain(other)));
    }
    Some(format!("{}.inputs:{}", graph?, plain(input.attribute("interfacename")?)))
}

/// The name of a node's definition; of those with several for one type, the letters that tell numbers from colours.
fn definition(node: &Element, own: &str) -> String {
    let first = node.all("input").find(|input| input.attribute("name") == Some("in1"));
    let mixed = node.name == "combine2" && first.is_some_and(|first| first.attribute("type") != Some("float"));
    format!("ND_{}_{own}{}", node.name, if mixed { "CF" } else { "" })
}

/// As the name of a prim or property.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

fn identifier(element: &Element) -> Result<String, String> {
    let name = element.attribute("name").map(plain).unwrap_or_default();
    if name.chars().next().is_none_or(|first| first.is_ascii_digit()) {
        return Err(format!("an element `{}` has no name", element.name));
    }
    Ok(name)
}

fn quoted(text: &str) -> String {
    let inner: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("\"{}\"", inner.replace('\\', "\\\\").replace('"', "\\\""))
}

/// USD's name of an element's type; none for those that no surface reads.
fn usd_type(element: &Element) -> Option<&'static str> {
    Some(match element.attribute("type")? {
        "float" => "float",
        "integer" => "int",
        "boolean" => "bool",
        "color3" => "color3f",
        "color4" => "color4f",
        "vector2" => "float2",
        "vector3" => "float3",
        "vector4" => "float4",
        "string" => "string",
        "filename" => "asset",
        "surfaceshader" | "displacementshader" | "BSDF" | "EDF" | "VDF" => "token",
        _ => return None,
    })
}

fn lanes(usd: &str) -> usize {
    match usd.as_bytes().last() {
        Some(b'2') => 2,
        _ if usd.contains('3') => 3,
        _ if usd.contains('4') => 4,
        _ => 1,
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    let parts = text.split([',', ' ', '\t', '\n', '\r']).filter(|part| !part.is_empty());
    parts.map(|part| part.parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// MaterialX' units of distance.
fn metres(unit: &str) -> Option<f64> {
    Some(match unit {
        "nanometer" => 1e-9,
        "micron" => 1e-6,
        "millimeter" => 1e-3,
        "centimeter" => 1e-2,
        "inch" => 0.0254,
        "foot" => 0.3048,
        "yard" => 0.9144,
        "meter" => 1.0,
        "kilometer" => 1e3,
        "mile" => 1609.344,
        _ => return None,
    })
}

/// MaterialX' names of colour spaces.
fn file_space(name: &str) -> Option<FileSpace> {
    FileSpace::of_interop_id(match name {
        "srgb_texture" => "srgb_rec709_scene",
        "acescg" | "lin_ap1" => "lin_ap1_scene",
        "lin_rec709" => "lin_rec709_scene",
        "g18_rec709" => "g18_rec709_scene",
        "g22_rec709" => "g22_rec709_scene",
        "lin_displayp3" => "lin_p3d65_scene",
        "srgb_displayp3" => "srgb_p3d65_scene",
        "adobergb" => "g22_adobergb_scene",
        "lin_adobergb" => "lin_adobergb_scene",
        other => other,
    })
}
