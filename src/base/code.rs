//! What a fault or a note is about, as data: rules, healing and reports decide by it, never by the words of a message.

/// The codes, each with the rule of `validate` whose finding it is.
macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident => $rule:literal,)*) => {
        /// One thing that can be wrong. It is set where the fault or the note arises; those without one are told apart
        /// only by how far reading had come.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Code {
            $($(#[$doc])* $name,)*
        }

        impl Code {
            pub const ALL: &'static [Code] = &[$(Code::$name),*];

            /// The rule whose finding it is.
            pub fn rule(self) -> &'static str {
                match self {
                    $(Code::$name => $rule,)*
                }
            }
        }
    };
}

codes! {
    /// Of the asset's own file, where no more is known.
    AssetUnreadable => "EB0001",
    SidecarUnreadable => "EB0002",
    /// Of a later version of the vocabulary.
    SchemaNewer => "EB0607",
    RequiredExtensionUnknown => "EB0003",
    ExtensionUnused => "EB0004",
    /// Of a warning of the importer, where no more is known.
    LeftOut => "EB0005",
    /// Of those that a picture can be without.
    TextureMissing => "EB0006",
    FileMissing => "EB0007",
    DataNotFinite => "EB0008",
    ScaleSuspicious => "EB0101",
    ShapeOffMesh => "EB0107",
    NormalsContradict => "EB0108",
    UnevenScale => "EB0111",
    PartFlattened => "EB0112",
    NormalsInsideOut => "EB0113",
    NothingToTrace => "EB0114",
    UnitUnsaid => "EB0115",
    IndexMissing => "EB0201",
    IndexImpossible => "EB0202",
    IndexExtrapolated => "EB0203",
    CoatingGainsEnergy => "EB0204",
    CoatingNotPolished => "EB0205",
    ScatterGainsEnergy => "EB0206",
    NamedUnused => "EB0207",
    NameUnknown => "EB0209",
    TableTooShort => "EB0210",
    TransmissionPartial => "EB0211",
    IndexContradicted => "EB0212",
    StrengthMissing => "EB0301",
    StrengthTwice => "EB0302",
    ProfileMissing => "EB0304",
    ProfileMalformed => "EB0305",
    ProfileBehindFace => "EB0306",
    LuminanceImplausible => "EB0308",
    EmitterWithoutArea => "EB0309",
    GroupUnusable => "EB0310",
    SpectrumUnusable => "EB0311",
    SlideWithoutSize => "EB0401",
    SlideImageMissing => "EB0402",
    EyeMissing => "EB0501",
    EyeInSolid => "EB0502",
    EyeImpossible => "EB0503",
    PartUnbound => "EB0601",
    SelectsNothing => "EB0602",
    AttributeUnknown => "EB0603",
    /// By two places of the same right.
    BoundTwice => "EB0604",
    /// By one place.
    SaidTwice => "EB0604",
    NameAmbiguous => "EB0605",
    AttributesOnNothing => "EB0606",
    /// Of attributes and what they name, where no more is known.
    ValueImpossible => "EB0607",
    /// Of the scene as a whole, where no more is known.
    SceneRefused => "EB0608",
}

impl Code {
    /// Of a file that could not be read: whether it is not there, as far as the system says so.
    pub fn of_reading(error: &std::io::Error) -> Option<Code> {
        (error.kind() == std::io::ErrorKind::NotFound).then_some(Code::FileMissing)
    }
}
