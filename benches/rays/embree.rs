//! Embree 4 beside us: its library, loaded at run time, so that nobody needs it who does not compare. Facts of the
//! interface: `include/embree4/rtcore*.h` of RenderKit/embree 4.4.

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;

unsafe extern "C" {
    /// dlopen(3) and dlsym(3) of the C library that `std` is linked to.
    fn dlopen(path: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

/// RTLD_NOW of <dlfcn.h>.
const NOW: c_int = 2;
/// RTC_BUFFER_TYPE_INDEX and _VERTEX, RTC_FORMAT_UINT3 and _FLOAT3, RTC_BUILD_QUALITY_MEDIUM and _HIGH.
const INDEX: c_int = 0;
const VERTEX: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const MEDIUM: c_int = 1;
const HIGH: c_int = 2;
/// RTC_SCENE_FLAG_ROBUST.
const ROBUST: c_int = 4;

/// RTCRayHit.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    dir: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    uv: [f32; 2],
    triangle: u32,
    geometry: u32,
    instance: [u32; 2],
}

type Handle = *mut c_void;
type Intersect = unsafe extern "C" fn(Handle, *mut RayHit, *const c_void);

/// How a scene is built and walked.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Triangles split in the tree, else as by default.
    high: bool,
    /// No ray slips between triangles, else as by default.
    robust: bool,
}

pub const KINDS: [Kind; 4] = [
    Kind { high: false, robust: true },
    Kind { high: false, robust: false },
    Kind { high: true, robust: true },
    Kind { high: true, robust: false },
];

/// A scene of one triangle mesh.
pub struct Embree {
    scene: Handle,
    intersect: Intersect,
}

impl Embree {
    /// Builds a static scene on one thread.
    pub fn new(library: &Path, positions: &[[f32; 3]], triangles: &[[u32; 3]], kind: Kind) -> Embree {
        let path = CString::new(library.to_string_lossy().as_bytes()).expect("a path");
        // SAFETY: the library is what its user says, and its functions are declared as in its headers; buffers that it
        // makes are as long as it was asked for, with some more bytes.
        unsafe {
            let library = dlopen(path.as_ptr(), NOW);
            assert!(!library.is_null(), "no library at {path:?}");
            let function = |name: &str| {
                let place = dlsym(library, CString::new(name).expect("a name").as_ptr());
                assert!(!place.is_null(), "the library has no {name}");
                place
            };
            macro_rules! call {
                ($name:literal, ($($kind:ty),*) -> $out:ty, $($value:expr),*) => {
                    std::mem::transmute::<*mut c_void, unsafe extern "C" fn($($kind),*) -> $out>(function($name))($($value),*)
                };
            }
            let device = call!("rtcNewDevice", (*const c_char) -> Handle, c"threads=1,set_affinity=0".as_ptr());
            let scene = call!("rtcNewScene", (Handle) -> Handle, device);
            call!("rtcSetSceneBuildQuality", (Handle, c_int) -> (), scene, if kind.high { HIGH } else { MEDIUM });
            call!("rtcSetSceneFlags", (Handle, c_int) -> (), scene, if kind.robust { ROBUST } else { 0 });
            let mesh = call!("rtcNewGeometry", (Handle, c_int) -> Handle, device, 0);
            let fill = |which: c_int, format: c_int, words: &[u32]| {
                let buffer = call!("rtcSetNewGeometryBuffer", (Handle, c_int, u32, c_int, usize, usize) -> *mut u32,
                    mesh, which, 0, format, 12, words.len() / 3);
                assert!(!buffer.is_null(), "no buffer for {} words", words.len());
                std::ptr::copy_nonoverlapping(words.as_ptr(), buffer, words.len());
            };
            fill(INDEX, UINT3, triangles.as_flattened());
            fill(VERTEX, FLOAT3, &positions.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>());
            call!("rtcSetGeometryBuildQuality", (Handle, c_int) -> (), mesh, if kind.high { HIGH } else { MEDIUM });
            call!("rtcCommitGeometry", (Handle) -> (), mesh);
            call!("rtcAttachGeometry", (Handle, Handle) -> u32, scene, mesh);
            call!("rtcCommitScene", (Handle) -> (), scene);
            let fault = call!("rtcGetDeviceError", (Handle) -> c_int, device);
            assert_eq!(fault, 0, "Embree refuses the mesh");
            Embree { scene, intersect: std::mem::transmute::<*mut c_void, Intersect>(function("rtcIntersect1")) }
        }
    }

    /// t of the closest hit of one ray, infinite if there is none.
    #[inline]
    pub fn intersect(&self, ray: &[f32; 6]) -> f32 {
        let [ox, oy, oz, dx, dy, dz] = *ray;
        let mut ray = RayHit {
            origin: [ox, oy, oz],
            near: 0.0,
            dir: [dx, dy, dz],
            time: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            triangle: u32::MAX,
            geometry: u32::MAX,
            instance: [u32::MAX; 2],
        };
        // SAFETY: a committed scene, a whole ray, and no arguments, which stands for the usual ones.
        unsafe { (self.intersect)(self.scene, &mut ray, std::ptr::null()) };
        if ray.geometry == u32::MAX { f32::INFINITY } else { ray.far }
    }
}
