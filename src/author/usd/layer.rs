//! A USD layer as data, before it is text or a crate: prims in the order of the file, each with its depth. Only what we
//! write exists here.

/// A value of a property or of metadata. The USD type is the variant's own unless a property names another role of the
/// same shape (`point3f[]` for [`Datum::Float3s`]).
#[derive(Debug, Clone, PartialEq)]
pub enum Datum {
    Bool(bool),
    Int(i32),
    Ints(Vec<i32>),
    Float(f32),
    Floats(Vec<f32>),
    Double(f64),
    Doubles(Vec<f64>),
    Text(String),
    Texts(Vec<String>),
    Token(String),
    Tokens(Vec<String>),
    Asset(String),
    Assets(Vec<String>),
    Int2([i32; 2]),
    Float2([f32; 2]),
    Float2s(Vec<[f32; 2]>),
    Float3([f32; 3]),
    Float4([f32; 4]),
    Float3s(Vec<[f32; 3]>),
    Double2([f64; 2]),
    Double2s(Vec<[f64; 2]>),
    Double3([f64; 3]),
    Double3s(Vec<[f64; 3]>),
    /// Written as half precision.
    Half3s(Vec<[f32; 3]>),
    /// w, x, y, z.
    Quat([f64; 4]),
    Quats(Vec<[f32; 4]>),
    /// Rows as USD writes them: a point is a row that stands left of the matrix.
    Matrix([[f64; 4]; 4]),
    Matrices(Vec<[[f64; 4]; 4]>),
    /// Nothing, whatever weaker layers say, for a property of this type.
    Blocked(&'static str),
}

impl Datum {
    /// The USD type that goes with the variant.
    pub fn type_name(&self) -> &'static str {
        match self {
            Datum::Bool(_) => "bool",
            Datum::Int(_) => "int",
            Datum::Ints(_) => "int[]",
            Datum::Float(_) => "float",
            Datum::Floats(_) => "float[]",
            Datum::Double(_) => "double",
            Datum::Doubles(_) => "double[]",
            Datum::Text(_) => "string",
            Datum::Texts(_) => "string[]",
            Datum::Token(_) => "token",
            Datum::Tokens(_) => "token[]",
            Datum::Asset(_) => "asset",
            Datum::Assets(_) => "asset[]",
            Datum::Int2(_) => "int2",
            Datum::Float2(_) => "float2",
            Datum::Float2s(_) => "float2[]",
            Datum::Float3(_) => "float3",
            Datum::Float4(_) => "float4",
            Datum::Float3s(_) => "float3[]",
            Datum::Double2(_) => "double2",
            Datum::Double2s(_) => "double2[]",
            Datum::Double3(_) => "double3",
            Datum::Double3s(_) => "double3[]",
            Datum::Half3s(_) => "half3[]",
            Datum::Quat(_) => "quatd",
            Datum::Quats(_) => "quatf[]",
            Datum::Matrix(_) => "matrix4d",
            Datum::Matrices(_) => "matrix4d[]",
            Datum::Blocked(type_name) => type_name,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    pub name: String,
    /// No schema declares it.
    pub custom: bool,
    /// What the numbers of the picture that it names stand for.
    pub color_space: Option<&'static str>,
    pub body: Body,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    Attribute {
        type_name: &'static str,
        uniform: bool,
        value: Option<Datum>,
        /// Values by time code, increasing.
        samples: Vec<(f64, Datum)>,
        interpolation: Option<&'static str>,
        /// Elements of a list that are of one point.
        each: Option<usize>,
    },
    /// An attribute that takes its value from another one (a path with its property).
    Connected { type_name: &'static str, source: String },
    /// A relationship to prims.
    Relationship { targets: Vec<String> },
}

impl Property {
    pub fn new(name: impl Into<String>, value: Datum) -> Self {
        let type_name = value.type_name();
        Property {
            name: name.into(),
            custom: false,
            color_space: None,
            body: Body::Attribute {
                type_name,
                uniform: false,
                value: Some(value),
                samples: Vec::new(),
                interpolation: None,
                each: None,
            },
        }
    }
    /// An attribute that only declares itself: an output of a shader.
    pub fn declared(name: impl Into<String>, type_name: &'static str) -> Self {
        Property {
            name: name.into(),
            custom: false,
            color_space: None,
            body: Body::Attribute {
                type_name,
                uniform: false,
                value: None,
                samples: Vec::new(),
                interpolation: None,
                each: None,
            },
        }
    }
    pub fn connected(name: impl Into<String>, type_name: &'static str, source: String) -> Self {
        Property { name: name.into(), custom: false, color_space: None, body: Body::Connected { type_name, source } }
    }
    pub fn relationship(name: impl Into<String>, targets: Vec<String>) -> Self {
        Property { name: name.into(), custom: false, color_space: None, body: Body::Relationship { targets } }
    }
    /// Values at times.
    pub fn sampled(mut self, at: Vec<(f64, Datum)>) -> Self {
        if let Body::Attribute { samples, .. } = &mut self.body {
            *samples = at;
        }
        self
    }
    /// So many elements are of one point.
    pub fn each(mut self, count: usize) -> Self {
        if let Body::Attribute { each, .. } = &mut self.body {
            *each = Some(count);
        }
        self
    }
    /// One value for all times.
    pub fn uniform(mut self) -> Self {
        if let Body::Attribute { uniform, .. } = &mut self.body {
            *uniform = true;
        }
        self
    }
    /// Another role of the same shape, e.g. `point3f[]`.
    pub fn typed(mut self, role: &'static str) -> Self {
        if let Body::Attribute { type_name, .. } = &mut self.body {
            *type_name = role;
        }
        self
    }
    pub fn per(mut self, what: &'static str) -> Self {
        if let Body::Attribute { interpolation, .. } = &mut self.body {
            *interpolation = Some(what);
        }
        self
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Specifier {
    #[default]
    Def,
    Over,
    Class,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prim {
    /// 0 for a root prim; at most one more than that of the prim before it.
    pub depth: usize,
    pub specifier: Specifier,
    /// Empty: none.
    pub type_name: &'static str,
    /// An identifier, unique among its siblings.
    pub name: String,
    pub kind: Option<&'static str>,
    pub instanceable: Option<bool>,
    /// Applied schemas, prepended.
    pub schemas: Vec<String>,
    /// A prim of this layer that this one refers to.
    pub reference: Option<String>,
    /// The name as people know it, where it is no identifier.
    pub display_name: Option<String>,
    /// `customData["eyebox"]`.
    pub marks: Vec<(&'static str, Datum)>,
    pub properties: Vec<Property>,
}

impl Prim {
    pub fn def(depth: usize, type_name: &'static str, name: impl Into<String>) -> Self {
        Prim { depth, type_name, name: name.into(), ..Prim::default() }
    }
    pub fn push(&mut self, property: Property) {
        self.properties.push(property);
    }
    /// Applies a schema, once.
    pub fn apply(&mut self, schema: &str) {
        if !self.schemas.iter().any(|known| known == schema) {
            self.schemas.push(schema.to_owned());
        }
    }
}

/// A layer. The file is a function of this alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// Metadata of the layer, in order, e.g. `metersPerUnit`.
    pub metadata: Vec<(&'static str, Datum)>,
    /// Asset paths of the layers below this one, strongest first.
    pub sublayers: Vec<String>,
    pub prims: Vec<Prim>,
}
