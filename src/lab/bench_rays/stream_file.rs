//! Ray-stream files. See docs/ray-streams.md for the byte layout.
//!
//! Files are untrusted. The reader checks the counts against the file's length, the content against its hash, and each
//! ray's class against the known ones. Rays may have any bit pattern with one exception: a negative first parameter,
//! which backends do not accept.

use super::RayStream;
use crate::accel::RayClass;
use crate::error::{Error, Kind, Result};
use crate::geometry::Ray;
use crate::io::atomic::write_atomically;
use crate::io::hashed::Hashed;
use crate::lab::bench_rays::{Query, RayQuery};
use glam::Vec3;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"\x89ETRAYS\n";
const VERSION: u32 = 1;
const HASH: usize = blake3::OUT_LEN;
/// Length of a scene hash in characters.
const SCENE: usize = 32;
/// Size of the prefix: magic, version, length of the name, hash of the scene, counts of three classes.
const PREFIX: usize = 8 + 4 + 4 + SCENE + 3 * 8;
/// Size of a ray: its class and eight floats.
const RAY: usize = 4 + 8 * 4;
const MOST_NAME: u32 = 4096;

const CAMERA: u32 = 0;
const BOUNCE: u32 = 1;
const SHADOW: u32 = 2;
/// Flag of an occlusion query.
const OCCLUDED: u32 = 4;
/// First bit of the bounce depth.
const DEPTH: u32 = 3;

/// Writes a stream.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written.
pub fn write(path: &Path, stream: &RayStream) -> Result<()> {
    write_atomically(path, |file| {
        let mut out = Hashed::new(BufWriter::new(file));
        out.write_all(&prefix(stream)?)?;
        out.write_all(stream.name.as_bytes())?;
        stream.questions.iter().try_for_each(|question| out.write_all(&ray_bytes(question)?))?;
        let hash = out.hasher.finalize();
        out.inner.write_all(hash.as_bytes())?;
        out.inner.flush()
    })
}

fn prefix(stream: &RayStream) -> io::Result<Vec<u8>> {
    let length = u32::try_from(stream.name.len()).ok().filter(|&length| length <= MOST_NAME);
    let length = length.ok_or_else(|| io::Error::other("the stream's name is too long"))?;
    let scene = Some(stream.scene_hash.as_bytes()).filter(|hash| hash.len() == SCENE);
    let scene = scene.ok_or_else(|| io::Error::other("the scene's hash is not 32 characters"))?;
    let counts = counts(&stream.questions).map(u64::to_le_bytes).concat();
    Ok([&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes(), scene, &counts].concat())
}

/// Counts of camera, bounce and shadow rays.
fn counts(questions: &[RayQuery]) -> [u64; 3] {
    let mut counts = [0; 3];
    for question in questions {
        counts[match question.class {
            RayClass::Camera => CAMERA,
            RayClass::Bounce(_) => BOUNCE,
            RayClass::Shadow => SHADOW,
        } as usize] += 1;
    }
    counts
}

fn ray_bytes(RayQuery { ray, query, class }: &RayQuery) -> io::Result<[u8; RAY]> {
    let what = match *class {
        RayClass::Camera => CAMERA,
        RayClass::Bounce(depth) if depth < 1 << (32 - DEPTH) => BOUNCE | depth << DEPTH,
        RayClass::Bounce(_) => return Err(io::Error::other("a bounce is too deep")),
        RayClass::Shadow => SHADOW,
    };
    let what = if *query == Query::Occluded { what | OCCLUDED } else { what };
    let numbers = [&ray.origin.to_array()[..], &ray.direction.to_array(), &[ray.t_min, ray.t_max]].concat();
    let mut bytes = [0; RAY];
    bytes[..4].copy_from_slice(&what.to_le_bytes());
    for (to, number) in bytes[4..].chunks_exact_mut(4).zip(numbers) {
        to.copy_from_slice(&number.to_le_bytes());
    }
    Ok(bytes)
}

/// Reads a stream.
///
/// # Errors
/// [`Kind::Scene`] with the path if the file is missing, not a ray stream, of another version, or damaged;
/// [`Kind::Memory`] if its rays do not fit.
pub fn read(path: &Path) -> Result<RayStream> {
    // Opening a pipe or a device could block.
    let metadata = std::fs::metadata(path).map_err(|cause| Error::read(path, cause))?;
    if !metadata.is_file() {
        return Err(Error::scene(format!("cannot read {}: it is not a file", path.display())));
    }
    let file = File::open(path).map_err(|cause| Error::read(path, cause))?;
    let result = read_from(BufReader::new(file), metadata.len());
    result.map_err(|e| Error::new(e.kind, format!("cannot read ray stream {}: {}", path.display(), e.chain())))
}

/// Reads a stream of `size` bytes.
fn read_from(file: impl Read, size: u64) -> Result<RayStream> {
    let mut file = Hashed::new(file);
    let mut prefix = [0; PREFIX];
    file.read_exact(&mut prefix[..MAGIC.len() + 4]).map_err(|_| foreign())?;
    if prefix[..MAGIC.len()] != MAGIC {
        return Err(foreign());
    }
    let version = word(&prefix[8..]);
    if version != VERSION {
        return Err(Error::scene(format!("it is of version {version}, and this étendue reads version {VERSION}")));
    }
    file.read_exact(&mut prefix[MAGIC.len() + 4..]).map_err(damaged)?;
    let name_length = word(&prefix[12..]);
    let counts = [0, 1, 2].map(|class| long(&prefix[16 + SCENE + 8 * class..]));
    let rays = check_size(size, name_length, counts)?;
    let mut name = vec![0; name_length as usize];
    file.read_exact(&mut name).map_err(damaged)?;
    let name = String::from_utf8(name).map_err(damaged)?;
    let questions = read_rays(&mut file, rays)?;
    let hash = file.hasher.finalize();
    let mut expected = [0; HASH];
    file.inner.read_exact(&mut expected).map_err(damaged)?;
    // The checksum comes first: any other defect may be due to a flipped bit.
    if hash != expected {
        return Err(Error::scene("its checksum is wrong"));
    }
    let questions = questions?;
    if self::counts(&questions) != counts {
        return Err(Error::scene("its counts are not those of its rays"));
    }
    let scene_hash = String::from_utf8(prefix[16..16 + SCENE].to_vec()).map_err(damaged)?;
    Ok(RayStream { name, scene_hash, questions })
}

/// Returns the number of rays, if it fits the file's size.
fn check_size(size: u64, name_length: u32, counts: [u64; 3]) -> Result<usize> {
    let rays = counts.iter().try_fold(0u64, |sum, &count| sum.checked_add(count));
    let bytes = rays.and_then(|rays| rays.checked_mul(RAY as u64));
    let bytes = bytes.and_then(|bytes| bytes.checked_add((PREFIX + HASH) as u64 + u64::from(name_length)));
    match rays {
        _ if name_length > MOST_NAME => Err(Error::scene("its name is too long")),
        Some(rays) if bytes == Some(size) => u32::try_from(rays)
            .map(|rays| rays as usize)
            .map_err(|_| Error::new(Kind::Memory, "it has more than 2^32 - 1 rays")),
        _ => Err(Error::scene("it is not as long as its counts say")),
    }
}

/// Reads all rays. The inner error is the first invalid ray.
fn read_rays(file: &mut impl Read, count: usize) -> Result<Result<Vec<RayQuery>>> {
    let mut questions = Vec::new();
    questions.try_reserve_exact(count).map_err(|_| Error::new(Kind::Memory, "its rays do not fit into memory"))?;
    let (mut bytes, mut wrong) = ([0; RAY], None);
    for place in 0..count {
        file.read_exact(&mut bytes).map_err(damaged)?;
        match question(&bytes) {
            Ok(question) => questions.push(question),
            Err(what) => wrong = wrong.or_else(|| Some(Error::scene(format!("ray {place} {what}")))),
        }
    }
    Ok(wrong.map_or(Ok(questions), Err))
}

fn question(bytes: &[u8; RAY]) -> std::result::Result<RayQuery, &'static str> {
    let what = word(bytes);
    let query = if what & OCCLUDED == 0 { Query::Closest } else { Query::Occluded };
    let class = match (what & 3, what >> DEPTH) {
        (CAMERA, 0) => RayClass::Camera,
        (BOUNCE, depth) if depth > 0 => RayClass::Bounce(depth),
        (SHADOW, 0) => RayClass::Shadow,
        _ => return Err("is of no class that there is"),
    };
    let [ox, oy, oz, dx, dy, dz, t_min, t_max] =
        [1, 2, 3, 4, 5, 6, 7, 8].map(|i| f32::from_bits(word(&bytes[4 * i..])));
    if t_min < 0.0 {
        return Err("begins before its origin");
    }
    let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    Ok(RayQuery { ray: Ray { t_min, t_max, ..Ray::new(origin, direction) }, query, class })
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn long(bytes: &[u8]) -> u64 {
    u64::from(word(bytes)) | u64::from(word(&bytes[4..])) << 32
}

fn foreign() -> Error {
    Error::scene("it is not a ray stream")
}

fn damaged(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::scene("it is damaged").because(cause)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    /// Rays of all classes, with unusual bit patterns.
    fn stream() -> RayStream {
        let ray = |x: f32| Ray { t_min: 0.25, t_max: x, ..Ray::new(Vec3::new(x, -0.0, f32::NAN), Vec3::splat(x)) };
        let ask = |class, query, x| RayQuery { ray: ray(x), query, class };
        let questions = vec![
            ask(RayClass::Camera, Query::Closest, 1.5),
            ask(RayClass::Bounce(1), Query::Closest, f32::INFINITY),
            ask(RayClass::Shadow, Query::Occluded, f32::from_bits(1)),
            ask(RayClass::Bounce((1 << 29) - 1), Query::Closest, f32::from_bits(0x7fa0_1234)),
            ask(RayClass::Shadow, Query::Closest, -3.0),
        ];
        RayStream { name: "α box".into(), scene_hash: "0123456789abcdef".repeat(2), questions }
    }

    /// The file of this stream.
    fn bytes() -> Vec<u8> {
        static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.rays");
            write(&path, &stream()).unwrap();
            std::fs::read(path).unwrap()
        });
        BYTES.clone()
    }

    fn words(stream: &RayStream) -> Vec<[u8; RAY]> {
        stream.questions.iter().map(|question| ray_bytes(question).unwrap()).collect()
    }

    fn refused(bytes: &[u8]) -> String {
        let error = read_from(bytes, bytes.len() as u64).unwrap_err();
        assert_eq!(error.kind, Kind::Scene, "{error}");
        error.to_string()
    }

    /// The same bytes with a valid checksum.
    fn forged(mut bytes: Vec<u8>) -> Vec<u8> {
        let body = bytes.len() - HASH;
        let hash = blake3::hash(&bytes[..body]);
        bytes[body..].copy_from_slice(hash.as_bytes());
        bytes
    }

    #[test]
    fn round_trips_bit_by_bit() {
        let stream = stream();
        let bytes = bytes();
        assert_eq!(bytes.len(), PREFIX + stream.name.len() + RAY * stream.questions.len() + HASH);
        let back = read_from(&bytes[..], bytes.len() as u64).unwrap();
        assert_eq!((&back.name, &back.scene_hash), (&stream.name, &stream.scene_hash));
        assert_eq!(words(&back), words(&stream));
    }

    #[test]
    fn invalid_stream_with_valid_checksum_is_refused() {
        let bytes = bytes();
        let first = PREFIX + stream().name.len();
        let with = |at: usize, value: u32| {
            let mut changed = bytes.clone();
            changed[at..at + 4].copy_from_slice(&value.to_le_bytes());
            refused(&forged(changed))
        };
        assert!(with(8, 2).contains("version 2"));
        assert!(with(12, u32::MAX).contains("name"));
        assert!(with(16 + SCENE, 2).contains("as long as"));
        assert!(with(20 + SCENE, u32::MAX).contains("as long as"));
        for what in [3, 1, 8, 2 | 1 << 20] {
            assert!(with(first, what).contains("ray 0 is of no class"));
        }
        assert!(with(first, 1 | 1 << DEPTH).contains("counts"));
        assert!(with(first + 28, (-1.0f32).to_bits()).contains("ray 0 begins before"));
        assert!(refused(b"hello").contains("not a ray stream") && refused(b"").contains("not a ray stream"));
        let longer = [&bytes[..], b"x"].concat();
        assert!(refused(&longer).contains("as long as"));
    }

    proptest! {
        #[test]
        fn truncated_or_flipped_stream_is_one_error(cut in 0usize..10_000, at in 0usize..10_000, bit in 0u8..8) {
            let bytes = bytes();
            refused(&bytes[..cut % bytes.len()]);
            let mut flipped = bytes.clone();
            flipped[at % bytes.len()] ^= 1 << bit;
            refused(&flipped);
        }

        #[test]
        fn random_bytes_are_an_error(noise in proptest::collection::vec(any::<u8>(), 0..400)) {
            refused(&noise);
            let mut headed = bytes()[..16].to_vec();
            headed.extend(&noise);
            refused(&headed);
        }
    }
}
