//! Typed indices into the tables of a scene: a part can't be looked up with a face number.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        pub struct $name(pub u32);
        impl $name {
            pub fn index(self) -> usize { self.0 as usize }
            pub fn from_index(index: usize) -> Self {
                $name(u32::try_from(index).expect("a scene table outgrew u32"))
            }
        }
    };
}

id!(/// A mesh: geometry shared by the parts that instance it.
    MeshId);
id!(/// A part: a node with geometry.
    PartId);
id!(/// A medium: what fills a closed solid.
    MediumId);
id!(/// A coating: a stack of thin films.
    CoatingId);
id!(/// A slide: a thin transmissive picture.
    SlideId);
id!(/// A light group: the unit in which light is stored separately. The sky is a group too.
    GroupId);
id!(/// A measured intensity distribution.
    ProfileId);
id!(/// A diffraction grating.
    GratingId);
id!(/// A wave plate.
    WavePlateId);
id!(/// Measured scattering.
    ScatterId);
id!(/// A standard surface: how an ordinary material looks.
    SurfaceId);
