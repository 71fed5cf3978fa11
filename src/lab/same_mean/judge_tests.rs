use super::*;
use crate::film::Independent;
use crate::film::pyramid::Replicates;
use crate::stats::test_random::Random;

/// Distribution of a picture's samples; all have the mean 1.
#[derive(Clone, Copy)]
enum Noise {
    /// Exponential: mild noise.
    Smooth,
    /// In the left half, a share of the light comes from rare contributions. `expected` is their expected number in 64
    /// pixels of all replicates.
    Rare { share: f64, expected: f64 },
}

const REPLICATES: usize = 32;

fn picture(seed: u64, noise: Noise) -> Pyramid {
    sized(32, seed, noise)
}

fn sized(side: u32, seed: u64, noise: Noise) -> Pyramid {
    sized_of(side, seed, noise, Independent::Pixels)
}

fn sized_of(side: u32, seed: u64, noise: Noise, independent: Independent) -> Pyramid {
    let random = std::cell::RefCell::new(Random::new(seed));
    let crop = Crop { x0: 0, y0: 0, x1: side, y1: side };
    Pyramid::new(crop, independent, Replicates::of(&[1; REPLICATES]).unwrap(), |pixel, _, means| {
        let mut random = random.borrow_mut();
        means.clear();
        let left = pixel as u32 % side < side / 2;
        means.extend((0..REPLICATES).map(|_| match noise {
            Noise::Rare { share, expected } if left => {
                let chance = expected / (64.0 * REPLICATES as f64);
                let hit = random.uniform() < chance;
                (1.0 - share) * (0.9 + 0.2 * random.uniform())
                    + if hit { share / chance * random.exponential() } else { 0.0 }
            }
            _ => random.exponential(),
        }));
    })
}

fn differs(a: &Pyramid, b: &Pyramid, level: f64) -> bool {
    judged(&[a, b], &[0, 1], level).pairs[0].differs()
}

fn judged(pyramids: &[&Pyramid], methods: &[u8], level: f64) -> Judgement {
    let both = pyramids.iter().zip(methods);
    let pictures: Vec<_> = both.map(|(&pyramid, &method)| TestedPicture { pyramid, method, doubt: None }).collect();
    judge(&pictures, level)
}

/// Number of false rejections at level 0.05 among `runs` pairs of unbiased pictures.
fn false_alarms(side: u32, noise: [Noise; 2], runs: u64) -> u64 {
    let is_alarm = |i: &u64| differs(&sized(side, 2 * i + 1, noise[0]), &sized(side, 2 * i + 2, noise[1]), 0.05);
    (0..runs).filter(is_alarm).count() as u64
}

/// At this level, more than 0.05 n + 4 √(0.0475 n) false rejections have a probability below 1e-3. In the rarest case a
/// picture expects ten large contributions; the head of the module describes the limits below.
#[test]
fn equal_means_are_rejected_at_most_at_the_level() {
    let rare = |share, expected| Noise::Rare { share, expected };
    for (name, side, noise) in [
        ("smooth", 32, [Noise::Smooth; 2]),
        ("some events in a tile", 32, [rare(0.5, 20.0), Noise::Smooth]),
        ("an event in a tile", 32, [rare(0.5, 1.0), Noise::Smooth]),
        ("an event in some tiles", 64, [rare(0.5, 0.3), rare(0.1, 100.0)]),
        ("both rare", 32, [rare(0.3, 2.0); 2]),
    ] {
        let runs = if side > 32 { 40 } else { 100 };
        let found = false_alarms(side, noise, runs);
        println!("{name}: {found} of {runs} at level 0.05");
        let n = runs as f64;
        assert!((found as f64) < 0.05 * n + 4.0 * (0.0475 * n).sqrt(), "{name}: {found} of {runs}");
    }
}

/// Image means of 3 × 32768 exponential values have a relative error of 0.55 % in each channel, so that 8 % is
/// detected.
#[test]
fn detectable_difference_predicts_the_rejection() {
    let (a, b) = (picture(1, Noise::Smooth), picture(2, Noise::Smooth));
    let judgement = judged(&[&a, &b], &[0, 1], 1e-3);
    let detectable = judgement.pairs[0].detectable.unwrap();
    assert!((0.02..0.06).contains(&detectable), "{detectable}");
    let trials = 40;
    let found = |factor: f64| {
        let convicted = |&i: &u64| {
            differs(&picture(100 + 2 * i, Noise::Smooth).times(factor), &picture(101 + 2 * i, Noise::Smooth), 1e-3)
        };
        (0..trials).filter(convicted).count()
    };
    // The detection probability is at least 90 % in one channel: fewer than 28 of 40 has a probability below 1e-3.
    assert!(found(1.0 + detectable) >= 28);
    assert!(found(1.0 + 2.0 * detectable) == 40);
}

/// A bright tile in an otherwise unbiased picture is found at its position.
#[test]
fn local_difference_is_located_in_its_tile() {
    let (a, mut b) = (picture(5, Noise::Smooth), picture(6, Noise::Smooth));
    let wrong = picture(7, Noise::Smooth).times(1.6);
    b.levels[0].tiles[6] = wrong.levels[0].tiles[6].clone();
    let judgement = judged(&[&a, &b], &[0, 1], 1e-3);
    let tile = judgement.pairs[0].tile.unwrap();
    assert!(judgement.pairs[0].differs() && tile.p_value < 1e-3);
    assert_eq!(tile.area, Crop { x0: 16, y0: 8, x1: 24, y1: 16 });
    assert!(tile.interval[1] < 0.0 && tile.interval[0] < tile.relative && tile.relative < tile.interval[1]);
}

#[test]
fn black_image_differs_within_a_method_and_is_undecided_between_methods() {
    let (a, black) = (picture(8, Noise::Smooth), picture(9, Noise::Smooth).times(0.0));
    let differs = |methods: [u8; 2]| judged(&[&a, &black], &methods, 1e-3).pairs[0].differs();
    assert!(differs([1, 1]));
    assert!(!differs([1, 2]));
}

/// A picture with identical replicates.
fn exact(value: f64) -> Pyramid {
    let crop = Crop { x0: 0, y0: 0, x1: 16, y1: 16 };
    Pyramid::new(crop, Independent::Pixels, Replicates::of(&[1; REPLICATES]).unwrap(), |_, _, means| {
        means.clear();
        means.resize(REPLICATES, value);
    })
}

/// Without noise every difference is significant, as between a mirror that shows 0.8 and a black one.
#[test]
fn images_without_noise_differ_if_their_means_do() {
    let differs = |a: f64, b: f64| {
        [[1, 1], [1, 2]].map(|methods| judged(&[&exact(a), &exact(b)], &methods, 1e-9).pairs[0].differs())
    };
    assert_eq!(differs(0.8, 0.0), [true; 2]);
    assert_eq!(differs(0.0, 0.8), [true; 2]);
    assert_eq!(differs(0.399, 1.0), [true; 2]);
    assert_eq!(differs(0.8, 0.8), [false; 2]);
    assert_eq!(differs(0.0, 0.0), [false; 2]);
    // Rounding of f32.
    assert_eq!(differs(0.8, 0.8 * (1.0 + 1e-6)), [false; 2]);
}

/// The darker picture may have missed light of an undersampled tail, up to its bound. The brighter one has no such
/// allowance.
#[test]
fn untrusted_darker_image_is_allowed_its_unseen_light() {
    let (plain, bright) = (picture(20, Noise::Smooth), picture(21, Noise::Smooth).times(1.3));
    let light = plain.image_mean(0).value * plain.image().pixels;
    // Missed light of each picture, as a fraction of the light of the darker one.
    let outcome = |missed: [Option<f64>; 2]| {
        let doubt = |share: f64| Doubt { sentence: "a tail", unseen: share * light };
        let [plain, bright] = [(&plain, missed[0]), (&bright, missed[1])].map(|(pyramid, share)| TestedPicture {
            pyramid,
            method: 0,
            doubt: share.map(doubt),
        });
        judge(&[plain, bright], 1e-3)
    };
    assert_eq!(outcome([None, None]).outcome(), Outcome::Differ);
    assert_eq!(outcome([None, Some(f64::INFINITY)]).outcome(), Outcome::Differ);
    assert_eq!(outcome([Some(0.1), None]).outcome(), Outcome::Differ);
    for missed in [[Some(0.4), None], [Some(f64::INFINITY), None], [Some(f64::INFINITY); 2]] {
        let untold = outcome(missed);
        assert_eq!((untold.outcome(), untold.pairs[0].tiles_different), (Outcome::CannotTell, 0));
    }
}

/// All pixels of a replicate fluctuate together, as under a single chain. At level 0.05, more than 10 + 3.1 √9.5
/// rejections of 200 pairs have a probability below 1e-3. With the pixels taken as independent, nearly all pairs are
/// rejected.
#[test]
fn noise_common_to_all_pixels_is_not_rejected() {
    let tied = |seed: u64, independent| {
        let mut random = Random::new(seed);
        let scales: Vec<f64> = (0..16).map(|_| (0..8).map(|_| random.exponential()).sum::<f64>() / 8.0).collect();
        let crop = Crop { x0: 0, y0: 0, x1: 16, y1: 16 };
        Pyramid::new(crop, independent, Replicates::of(&[1; 16]).unwrap(), |pixel, _, means| {
            means.clear();
            means.extend(scales.iter().enumerate().map(|(r, s)| s * (1.0 + 0.1 * ((pixel * 7 + r * 5) % 11) as f64)));
        })
    };
    let alarms = |independent| {
        let alarm = |&i: &u64| differs(&tied(2 * i + 1000, independent), &tied(2 * i + 1001, independent), 0.05);
        (0..200).filter(alarm).count()
    };
    for independent in [Independent::Replicates, Independent::Blocks] {
        let found = alarms(independent);
        assert!(found <= 19, "{independent:?}: {found} of 200");
    }
    assert!(alarms(Independent::Pixels) > 100);
}
