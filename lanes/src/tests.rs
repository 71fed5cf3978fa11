//! Every operation of every family returns the bits of one lane.

use crate::*;

/// Numbers with all bit patterns of interest: zeros of both signs, subnormals, infinities, large and small.
fn numbers() -> Vec<f32> {
    let special = [0.0, -0.0, 1.0, -1.0, 1e-42, -1e-42, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE];
    let mut state = 1u32;
    let mut random = move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 9) as f32 * 1e-5 - 30.0
    };
    special.into_iter().chain((0..54).map(|_| random())).collect()
}

fn integers() -> Vec<u32> {
    numbers().iter().map(|x| x.to_bits().rotate_left(7)).collect()
}

fn longs() -> Vec<u64> {
    integers().iter().map(|&x| u64::from(x).wrapping_mul(0x9e37_79b9_7f4a_7c15)).collect()
}

/// Applies `f` group by group and returns the bits of all lanes.
fn floats<F: Float>(f: impl Fn(F, F, F) -> F) -> Vec<u32> {
    let (a, n) = (numbers(), numbers().len());
    let turned = |by: usize| -> Vec<f32> { (0..n).map(|i| a[(i * 7 + by) % n]).collect() };
    let (b, c) = (turned(1), turned(5));
    let mut result = vec![0.0; n];
    for at in (0..n).step_by(F::LANES) {
        f(F::load(&a, at), F::load(&b, at), F::load(&c, at)).store(&mut result, at);
    }
    // The sign and payload of a NaN are not part of IEEE 754's result.
    result.into_iter().map(|x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() }).collect()
}

fn words<F: Float>(f: impl Fn(F::Int, F::Int) -> F::Int) -> Vec<u32> {
    let (a, n) = (integers(), integers().len());
    let b: Vec<u32> = (0..n).map(|i| a[(i * 7 + 1) % n]).collect();
    let mut result = vec![0; n];
    for at in (0..n).step_by(F::LANES) {
        f(F::Int::load(&a, at), F::Int::load(&b, at)).store(&mut result, at);
    }
    result
}

fn long_words<F: Float>(f: impl Fn(F::Long) -> F::Long) -> Vec<u64> {
    let (a, mut result) = (longs(), vec![0; longs().len()]);
    for at in (0..a.len()).step_by(F::LANES) {
        f(F::Long::load(&a, at)).store(&mut result, at);
    }
    result
}

/// Everything that kernels use, as bits.
fn everything<F: Float>() -> Vec<Vec<u64>> {
    let wide = |x: Vec<u32>| x.into_iter().map(u64::from).collect::<Vec<_>>();
    let as_float = |x: F::Int| F::from_int(x & F::Int::splat(0x7fff_ffff));
    let doubled = |[x, y]: [F::Double; 2]| {
        let sum = (x * y - x.abs()).max(y).min(F::Double::splat(1e30)) / F::Double::splat(3.0);
        [sum.sqrt() + x.at_most(y), -sum]
    };
    vec![
        wide(floats::<F>(|a, b, _| a + b)),
        wide(floats::<F>(|a, b, _| a - b)),
        wide(floats::<F>(|a, b, _| a * b)),
        wide(floats::<F>(|a, b, _| a / b)),
        wide(floats::<F>(|a, _, _| -a)),
        wide(floats::<F>(|a, b, c| a.mul_add(b, c))),
        wide(floats::<F>(|a, _, _| a.sqrt())),
        wide(floats::<F>(|a, _, _| a.abs())),
        wide(floats::<F>(|a, b, _| a.max(b))),
        wide(floats::<F>(|a, b, _| a.min(b))),
        wide(floats::<F>(|a, b, _| a.copysign(b))),
        wide(floats::<F>(|a, _, _| a.recip())),
        wide(floats::<F>(|a, b, c| F::select(a.below(b), c, a))),
        wide(floats::<F>(|a, b, c| F::select((a - b).equals(F::splat(0.0)) | a.equals(a.abs()), c, a))),
        wide(floats::<F>(|a, b, c| F::select(!a.above(b) & b.below(c) | c.below(a), c, a))),
        wide(floats::<F>(|a, b, c| F::select(a.at_most(b) | a.at_most(a.abs()), c, a))),
        wide(floats::<F>(|a, b, _| F::in_double([a, b], doubled)[0])),
        wide(floats::<F>(|a, b, _| F::in_double([a, b], doubled)[1])),
        wide(floats::<F>(|a, _, _| as_float(a.abs().min(F::splat(1e6)).to_int()))),
        wide(words::<F>(|a, b| a.wrapping_add(b))),
        wide(words::<F>(|a, b| a.wrapping_mul(b))),
        wide(words::<F>(|a, b| (a & b) ^ ((a | b) << 3) ^ (a >> 5))),
        wide(words::<F>(|a, _| a.reverse_bits())),
        long_words::<F>(|a| a.wrapping_mul(0xbf58_476d_1ce4_e5b9)),
        long_words::<F>(|a| (a ^ (a >> 27)).wrapping_add(F::Long::splat(0x9e37_79b9_7f4a_7c15))),
        long_words::<F>(|a| F::Long::from_int(a.high()).wrapping_mul(3) ^ F::Long::from_int(a.low())),
    ]
}

/// Packs what is above 0, in all three types, and returns it.
fn packed<F: Float>() -> (Vec<f32>, Vec<u32>, Vec<u64>) {
    let (x, i, l) = (numbers(), integers(), longs());
    let (mut a, mut b, mut c, mut next) = (vec![0.0; x.len() + 32], vec![0; x.len() + 32], vec![0; x.len() + 32], 0);
    for at in (0..x.len()).step_by(F::LANES) {
        let mask = F::load(&x, at).above(F::splat(0.0));
        F::load(&x, at).pack(mask, &mut a, next);
        F::Int::load(&i, at).pack(mask, &mut b, next);
        F::Long::load(&l, at).pack(mask, &mut c, next);
        next += mask.bits().count_ones() as usize;
    }
    (a[..next].to_vec(), b[..next].to_vec(), c[..next].to_vec())
}

fn family_is_one_lane<F: Float>() {
    for (number, (one, many)) in everything::<f32>().into_iter().zip(everything::<F>()).enumerate() {
        assert_eq!(one, many, "operation {number}");
    }
    let (one, many) = (packed::<f32>(), packed::<F>());
    assert_eq!((one.1, one.2), (many.1, many.2));
    assert_eq!(
        one.0.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        many.0.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
    for bits in [0, 1, 5, 0x80, 0xff, 0x5a] {
        let bits = bits & ((1u64 << F::LANES) - 1) as u32;
        let mask = F::Mask::from_bits(bits);
        assert_eq!((mask.bits(), mask.any()), (bits, bits != 0));
    }
    for count in 0..=F::LANES + 1 {
        assert_eq!(F::first(count).bits().count_ones() as usize, count.min(F::LANES));
    }
    let rows: Vec<[f32; ROW]> =
        (0..F::LANES).map(|row| std::array::from_fn(|column| (row * ROW + column) as f32)).collect();
    let mut back = vec![[0.0; ROW]; F::LANES];
    F::to_rows(F::rows(|lane| &rows[lane]), |lane, row| back[lane] = row);
    assert_eq!(back, rows);
    for (column, lanes) in F::rows(|lane| &rows[lane]).into_iter().enumerate() {
        for (lane, row) in rows.iter().enumerate() {
            assert_eq!(lanes.lane(lane).to_bits(), row[column].to_bits());
            assert_eq!(F::Int::from_fn(|lane| lane as u32).lane(lane), lane as u32);
            assert_eq!(F::from_fn(|lane| lane as f32).lane(lane).to_bits(), (lane as f32).to_bits());
        }
    }
}

#[test]
fn arrays_return_the_bits_of_one_lane() {
    family_is_one_lane::<Array<8>>();
    family_is_one_lane::<Array<4>>();
}

#[test]
fn the_native_family_returns_the_bits_of_one_lane() {
    family_is_one_lane::<Native>();
}

#[test]
fn bits_are_enumerated_from_the_lowest() {
    let mut seen = Vec::new();
    for_each_bit(0b1010_0001, |bit| seen.push(bit));
    assert_eq!(seen, [0, 5, 7]);
}
