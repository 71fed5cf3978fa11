//! Planted defects: wrong variants of right code, which measure the tests. With the feature `defects` one of them is
//! planted by `ETENDUE_DEFECT=name`; without it [`planted`] is a constant, and nothing of them is compiled.
//!
//! Each stands beside the right code as `if planted(Defect::X) { wrong } else { right }`. `make kill-matrix` plants
//! each in turn and runs tests/kill_matrix's killers against it. To add one, give it a row here, plant it, and see a
//! killer die of it. Limits: a defect must change pictures or figures in a way that a user would mind, and be no other
//! one in disguise.

/// Writes the enum and its table from rows `variant "name" "what is wrong" "where it is known from";`.
macro_rules! defects {
    ($($variant:ident $name:literal $wrong:literal $source:literal;)*) => {
        /// Something wrong that can be planted.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Defect {
            $(#[doc = $wrong] $variant,)*
        }

        impl Defect {
            /// All of them.
            pub const ALL: &'static [Defect] = &[$(Defect::$variant),*];

            /// What `ETENDUE_DEFECT` calls it.
            pub fn name(self) -> &'static str {
                match self { $(Defect::$variant => $name,)* }
            }

            /// What is wrong, in a sentence.
            pub fn wrong(self) -> &'static str {
                match self { $(Defect::$variant => $wrong,)* }
            }

            /// Where it is known from.
            pub fn known_from(self) -> &'static str {
                match self { $(Defect::$variant => $source,)* }
            }
        }
    };
}

defects! {
    // trust
    TrustByLuck "trust-by-luck"
        "An interval is trusted by the estimate of the tail's shape, whatever that may be off by."
        "Pareto k as most programs print it";
    CurvatureForgotten "curvature-forgotten"
        "The noise of denominators is left in relMSE: it is not extrapolated to denominators without noise."
        "a relative error divided by what was measured";
    PriorForgotten "prior-forgotten"
        "Whether an interval is trusted does not ask what the scene's features make a method miss."
        "an error bar that knows its samples only";
    PilotFollowsSeed "pilot-follows-seed"
        "The pilot's seed follows the render's, so that roulette and with it the error differ from seed to seed."
        "this renderer before its issue 8";
    // surfaces that touch
    ContactJumpedOver "contact-jumped-over"
        "Rays leave touching surfaces as they leave any other, by a distance that exceeds the gap."
        "ray tracers with an epsilon; this one, until glass stood on a table";
    ContactUnsorted "contact-unsorted"
        "Of surfaces closer than a backend's error the one that it names is taken for the first."
        "decals that flicker";
    CoplanarOnBothSides "coplanar-on-both-sides"
        "What coincides with the surface that is left is met whichever side it lies on, so that one layer counts twice."
        "renderers that know the primitive they leave and nothing of those that coincide with it";
    // sampling
    SobolSkipsFirst "sobol-skips-first"
        "The Sobol' sequence begins with its second point, so that no power of two of points is a net."
        "a common advice for unscrambled Sobol', and wrong for scrambled";
    OneScrambling "one-scrambling"
        "All replicates have one scrambling, so that they agree and the error bar vanishes."
        "randomised QMC with one seed";
    LightPickReused "light-pick-reused"
        "One number chooses the light and the point on it, so that each light shows one strip of itself."
        "renderers that save random dimensions without rescaling";
    TableOneBefore "table-one-before"
        "The discrete table takes the index before the right one."
        "off-by-one in a binary search";
    TriangleWithoutRoot "triangle-without-root"
        "Points on a triangle crowd at a corner, the square root being left out."
        "ray tracers' own maps to a triangle";
    UniformForCosine "uniform-for-cosine"
        "Directions are uniform over the hemisphere where their density says cosine."
        "the first path tracer of many";
    MixedHeuristics "mixed-heuristics"
        "Scattering is weighted by the balance heuristic and light samples by the power heuristic, so that weights do not sum to 1."
        "light-transport.md 1.5";
    // scattering
    GgxPdf2Percent "ggx-pdf-2-percent"
        "The density of reflection is 1.02 times too high."
        "field-survey.md 4.7";
    GgxPdfOfNormal "ggx-pdf-of-normal"
        "The density of reflection is that of the normal, the Jacobian of the half vector being left out."
        "the commonest error in microfacet models";
    GgxOneMasking "ggx-one-masking"
        "Reflection is masked toward the eye and not toward the light."
        "G1 taken for G2";
    GgxUncorrelated "ggx-uncorrelated"
        "Masking and shadowing are independent of one another, which darkens rough metal."
        "the older Smith G2";
    RefractionPdfWithoutEta2 "refraction-pdf-without-eta2"
        "pdf() of refraction lacks the square of the index that sample() has."
        "two copies of [Walter07 (17)]";
    Eta2Forgotten "eta2-forgotten"
        "Radiance is not scaled by the square of the refractive index."
        "light-transport.md 2.1";
    GrazingEmission "grazing-emission"
        "A walk may leave a light along its surface, with density 0: the weights of what it finds are not numbers."
        "found by chains, which ask for more samples than others";
    // chains
    HastingsForgotten "hastings-forgotten"
        "Acceptance compares targets alone, whatever the densities of the proposals."
        "Metropolis's rule taken for Hastings's";
    MutationTypeForgotten "mutation-type-forgotten"
        "That a kernel is taken with different probabilities at the two states is left out of the acceptance."
        "light-transport.md 2.4";
    ChainsShareStream "chains-share-stream"
        "All chains of a pass take the same random steps."
        "light-transport.md 2.5 (g)";
    NewCoordinatesZero "new-coordinates-zero"
        "A coordinate that a longer path needs begins at zero."
        "light-transport.md 2.5 (e)";
    FailedProposalsForgotten "failed-proposals-forgotten"
        "A proposal that leads off the film or nowhere is not a step: the state does not count once more."
        "light-transport.md 2.4";
    LitSeedsOnly "lit-seeds-only"
        "The normalisation is the mean of the samples that found light."
        "a mean over what was kept";
    SeedsAlike "seeds-alike"
        "Chains begin at any lit sample, bright or dim."
        "start-up bias, [Veach97 §11.3.1]";
    PassesAlike "passes-alike"
        "All passes have the same chains, so that they agree and the error bar vanishes."
        "a pass numbered by what it has in common with others";
    StepsStopAtEdges "steps-stop-at-edges"
        "Small steps end at the edges of the unit cube and do not go on at the other side."
        "a walk kept inside by clamping";
    ImportanceKept "importance-kept"
        "What a two-stage target divides by is not given back: dim parts of the picture are too bright."
        "[Veach97 §11.4.3] half done";
    SplatsUnlimited "splats-unlimited"
        "What bidirectional path tracing splats is not limited, and chains have what is above once more."
        "the limit where it is seen first";
    LengthsAlike "lengths-alike"
        "Paths of the class of all long ones are not weighed by the probability of their length."
        "light-transport.md 2.6";
    CopiedLobesWeighed "copied-lobes-weighed"
        "Perturbations count the probability of Dirac components that they copy."
        "a walk's density taken for a perturbation's";
    DeletionNotReevaluated "deletion-not-reevaluated"
        "The probability of deleting the new vertices is taken to be that of deleting the old ones."
        "light-transport.md 2.4";
    JacobianDropped "jacobian-dropped"
        "Perturbations do not weigh how they stretch area."
        "light-transport.md 2.4";
    FresnelFromOutside "fresnel-from-outside"
        "A smooth glass face reflects from inside as it does from outside: no total reflection."
        "the wrong side's index";
    SchlickFourth "schlick-fourth"
        "Schlick's Fresnel has the fourth power."
        "a multiplication too few";
    LeavingIsVacuum "leaving-is-vacuum"
        "Whoever leaves a body is in empty space, whatever lies around it."
        "renderers that keep one medium and not a stack";
    CameraInVacuum "camera-in-vacuum"
        "Cameras start in empty space, whatever they stand in."
        "étendue before it knew where cameras stand";
    LightsInVacuum "lights-in-vacuum"
        "Light starts in empty space, whatever its lamp stands in."
        "étendue before it knew where lamps stand";
    OuterIndexIsOne "outer-index-is-one"
        "Boundaries bend light as if empty space were outside, whatever lies there."
        "glass in water in most real-time renderers";
    PriorityReversed "priority-reversed"
        "Of overlapping bodies the one of the lowest priority has the place."
        "a comparison the wrong way round";
    PanesStopShadows "panes-stop-shadows"
        "Thin clear panes are opaque to connections, so that no sun shines through windows."
        "path tracers that take panes for mirrors";
    ThinLosesNothing "thin-loses-nothing"
        "A thin wall transmits what it has reflected already."
        "transmission without its Fresnel factor";
    LambertWithoutPi "lambert-without-pi"
        "The value of a diffuse surface is its albedo and not albedo over π, in eval() alone."
        "the π of lights given in other units";
    LobesChosenEvenly "lobes-chosen-evenly"
        "Lobes are chosen with probability one half where the density says by albedo."
        "three-gpu-pathtracer issue 847";
    RoughnessNotSquared "roughness-not-squared"
        "The roughness of a file is taken for α, of which it is the root."
        "glTF importers";
    BaseUncoupled "base-uncoupled"
        "The diffuse base under a layer is not divided by what the layer lets pass on average, and loses energy."
        "additive layering";
    // two normals
    CosineDropped "cosine-dropped"
        "The throughput lacks the cosine of a sampled direction."
        "field-survey.md 4.7";
    CosineToNg "cosine-to-ng"
        "Light samples take the cosine to the geometric normal, scattered ones that to the shading normal."
        "[Veach97 §5.3]";
    InstanceNormal "instance-normal"
        "Normals of instances are moved by the matrix and not by its inverse transpose."
        "every scene graph's first version";
    // lights
    PointLightLinear "point-light-linear"
        "A point light falls off with the distance and not with its square."
        "lights of raster engines";
    UnlitIsLamp "unlit-is-lamp"
        "Unlit surfaces light what is around them."
        "this renderer before issue 8";
    UnlitWithoutVertexColours "unlit-without-vertex-colours"
        "Unlit surfaces show no vertex colours."
        "this renderer before issue 8";
    SpotEdgeLinear "spot-edge-linear"
        "A spot's edge is a ramp and not the ramp's square."
        "KHR_lights_punctual read in haste";
    AreaPdfWithoutDistance "area-pdf-without-distance"
        "A density over area becomes one over solid angle without the squared distance."
        "light-transport.md 1.2";
    LampShinesBackward "lamp-shines-backward"
        "Light sampling takes single-sided lamps for two-sided ones; rays do not."
        "light-transport.md 2.1 (e)";
    HitPdfOverArea "hit-pdf-over-area"
        "Scattered rays are weighed against the lamp's density over area in place of that over solid angle."
        "light-transport.md 2.1 (d)";
    LightPmfNotInSample "light-pmf-not-in-sample"
        "A light sample is not divided by the probability of its light."
        "field-survey.md 4.7";
    LightPmfNotInHit "light-pmf-not-in-hit"
        "Light found by scattering is weighed without the probability of its light."
        "light-transport.md 2.1 (c)";
    EmissionTwiceAfterDirac "emission-twice-after-dirac"
        "The flag of a mirror bounce stays, so that emission counts in full again after the next bounce."
        "light-transport.md 2.1 (b)";
    EmissionLostAfterDirac "emission-lost-after-dirac"
        "Lamps are black in mirrors."
        "light-transport.md 2.1 (b)";
    MapRowsAlike "map-rows-alike"
        "Rows of an environment map are chosen as if all had the solid angle of the equator."
        "light-transport.md 2.14, the sine at the poles";
    MapHalfTexel "map-half-texel"
        "Rays look an environment map up half a texel beside the place that is sampled."
        "texel centres at whole numbers";
    MapTurnsBack "map-turns-back"
        "Samples of an environment map are turned against the rotation that rays see."
        "a sign in one of two places";
    // the walk
    ShadowsIgnoreMask "shadows-ignore-mask"
        "Leaves throw the shadow of their whole card."
        "light-transport.md 2.1 (g)";
    ShadowsIgnoreBlend "shadows-ignore-blend"
        "Half-transparent surfaces throw full shadows."
        "light-transport.md 2.1 (g)";
    SegmentMeetsItsEnd "segment-meets-its-end"
        "A segment to a lamp ends on the lamp and not before it."
        "étendue, before the far end had a bound";
    RouletteUnpaid "roulette-unpaid"
        "Survivors of roulette are not scaled up."
        "field-survey.md 4.7";
    DepthRouletteUnpaid "depth-roulette-unpaid"
        "Survivors of the roulette by depth are not scaled up, so that what leaves a trap of total reflection is dark."
        "renderers that cut long paths at random";
    RouletteEta2 "roulette-eta2"
        "Roulette decides with the square of the index divided out and pays with it left in."
        "light-transport.md 2.1 (h)";
    DepthOneMore "depth-one-more"
        "A limit of n scattering events lets n + 1 pass."
        "light-transport.md 2.1 (i)";
    GlassClear "glass-clear"
        "The inside of glass does not absorb along a path."
        "absorption in shadow rays alone";
    // paths
    SplatsCountedOnce "splats-counted-once"
        "MisStrategy take connections with the camera for as many as walks from the camera, not for as many as a whole pass has."
        "pbrt-v4 #347, where a crop was not in the weight";
    ReversePdfForgotten "reverse-pdf-forgotten"
        "MisStrategy take the density of the walk in hand for that of a walk the other way."
        "bidirectional path tracers on materials that are not symmetric";
    InfinityHasDistance "infinity-has-distance"
        "The place where light from infinity enters is taken per area of the surface and not perpendicular to the ray."
        "bidirectional path tracers with environment maps";
    DirectPdfIsEmissions "direct-pdf-is-emissions"
        "Light found by chance is weighted against emission's density where a receiver's is meant."
        "light-transport.md 2.3 (a)";
    SplatsWithoutMagnification "splats-without-magnification"
        "Connections with the camera do not know how large an area the film sees."
        "light tracers before a scene of another size";
    DiracConnects "dirac-connects"
        "MisStrategy think that a vertex can be connected which a mirror or clear glass was passed at."
        "bidirectional path tracers that replace densities of zero by one";
    TwoSidedWhole "two-sided-whole"
        "MisStrategy take a two-sided lamp to emit to each side as often as a one-sided one does."
        "emission densities that forget the choice of a side";
    EmissionPdfUniform "emission-pdf-uniform"
        "MisStrategy take lamps to emit in all directions alike, which they do by the cosine."
        "light-transport.md 2.2";
    NormalsDisagreeBlack "normals-disagree-black"
        "Nothing scatters where the two normals have a direction on different sides, so that glass with averaged normals loses light."
        "Veach97 §5.3, as most renderers follow it";
    NormalsNotEased "normals-not-eased"
        "Glass has the same normal on both sides of an edge, where total reflection traps light."
        "étendue, on a cube with corner normals";
    AdjointForgotten "adjoint-forgotten"
        "Walks from lights do not correct scattering for the difference of the two normals."
        "pbrt-v4 #385";
    Eta2BothWays "eta2-both-ways"
        "Walks from lights scale by the refractive index as those from the camera do."
        "light-transport.md 1.2";
    WeightsByShadingNormal "weights-by-shading-normal"
        "MisStrategy turn densities per solid angle into ones per area by the shading normal."
        "pbrt-v3 #73";
    SplatsOfTheWhole "splats-of-the-whole"
        "A crop divides its splats by the pixels of the whole image."
        "pbrt-v4 #347";
    SplatsHalfPixel "splats-half-pixel"
        "Splats fall half a pixel off."
        "pixel centres at whole numbers";
    SplatsOneDeeper "splats-one-deeper"
        "Connections with the camera may have one scattering event more than the limit."
        "the classic off-by-one of bidirectional methods";
    // camera and film
    PixelCorner "pixel-corner"
        "The filter stands on the pixel's corner: pictures are half a pixel off."
        "pixel centres at whole numbers";
    TentIsBox "tent-is-box"
        "The tent filter is a box of its width."
        "filter importance sampling without the root";
    FilmRoundsDown "film-rounds-down"
        "What the film adds is rounded down and not at random, so that dim light vanishes."
        "fixed-point accumulators";
    ReplicatesInTurn "replicates-in-turn"
        "The film gives pass k to replicate k / R, the sampler to k mod R."
        "two readings of one convention";
    MergeLosesCarry "merge-loses-carry"
        "Merging films drops the carry of sums that outgrow 64 bits."
        "étendue's own sums";
    // figures
    ErrorOfOneReplicate "error-of-one-replicate"
        "The standard error is that of one replicate and not of their mean."
        "a root of R forgotten";
    RelmseBiased "relmse-biased"
        "The noise in the denominators of relMSE is left in, which makes noisy images look worse than they are."
        "the plug-in estimator";
    PixelsForBlocks "pixels-for-blocks"
        "The interval of relMSE takes pixels for independent where samples fall on several at once, and is too narrow."
        "étendue, before blocks of pixels were taken together";
    PatchesForReplicates "patches-for-replicates"
        "The interval of relMSE takes parts of the picture for independent where chains serve all of it, and is far too narrow."
        "étendue, before it knew what a method shares";
    SquaresForPseudoValues "squares-for-pseudo-values"
        "The noise between replicates is that of their squared distances from the mean, which miss that the mean moves with each."
        "the jackknife written down from memory";
    NormalForT "normal-for-t"
        "Intervals from few replicates are those of a normal distribution."
        "1.96 for everything";
    HolmSingleStep "holm-single-step"
        "Holm's test multiplies every p-value by the number of tests, and finds less."
        "Bonferroni under another name";
    // invented as a reviewer, after the tests for those above
    BlendsShareNumber "blends-share-number"
        "All blended surfaces on a ray are decided by one number, so that two of alpha one half stop half of the light."
        "review: a number that is reused must be rescaled";
    LampMeanInSample "lamp-mean-in-sample"
        "Light samples of a textured lamp have its mean radiance and not that of their point."
        "review: the radiance that decides the choice";
    NormalMapGreen "normal-map-green"
        "The green channel of normal maps points down."
        "review: the other convention of normal maps";
    FeaturesIgnoreTextures "features-ignore-textures"
        "What a scene has is read off its factors, so that a texture's mirrors are not announced and its glass is missing."
        "issue 8, item 3";
    ExtremesAtVertices "extremes-at-vertices"
        "Extremes of a texture are those at the vertices, whatever lies between them."
        "review: a scan of coordinates in place of texels";
    TextureHalfTexel "texture-half-texel"
        "Textures lie half a texel beside their coordinates."
        "review: texel centres at whole numbers";
    CropAtOrigin "crop-at-origin"
        "A crop shows the upper left corner of the picture and not its window."
        "review: an offset forgotten";
    UvRotatesFirst "uv-rotates-first"
        "Texture coordinates are rotated before they are scaled, which shears the image where the scale is uneven."
        "review: KHR_texture_transform, its matrices in the other order";
    TangentsUntransformed "tangents-untransformed"
        "Tangents made for a normal map are those of coordinates that the map's transform was not applied to."
        "this renderer before issue 8; glTF-Sample-Assets issue 156";
    CameraKeepsScale "camera-keeps-scale"
        "The scale of a camera's node turns and shears its axes."
        "this renderer before issue 8; glTF 2.0, 3.10.2";
    MapSeam "map-seam"
        "The last column of an environment map blends with itself and not with the first, in sampling and lookup alike."
        "review: a border that is clamped and not wrapped";
    SpecularGrazesFull "specular-grazes-full"
        "The strength of KHR_materials_specular dims reflection at normal incidence and not at grazing angles."
        "review: an f90 of 1 whatever the material";
    DepthFromLastPane "depth-from-last-pane"
        "The depth layer counts from the last surface that the camera's ray passed and not from the camera."
        "review: a ray parameter taken for a distance";
    ReplicatesAlike "replicates-alike"
        "Replicates are divided by their mean number of passes and not by their own, so that error bars of interrupted renders are too wide."
        "review: sums that are taken for means";
    // same_mean
    ComparesPixels "compares-pixels"
        "Pixels that share light walks or chains are compared as if they were independent, so that healthy pictures are said to differ."
        "this renderer's own first `compare`";
    ExactIsNoise "exact-is-noise"
        "Two pictures without variance whose means differ are excused by bad luck, as if one had missed the light."
        "this renderer's own first `verify`";
    VerifyTrustsAll "verify-trusts-all"
        "A picture with a heavy tail that it has hardly met is convicted for being too dark."
        "this renderer's own first `verify`";
    // hashes
    HashOfAllOptions "hash-of-all-options"
        "The settings hash holds options that the method does not read, so that equal pictures refuse to merge."
        "this renderer's own first settings hash";
    HashForgetsLargeStep "hash-forgets-large-step"
        "The settings hash leaves the probability of large steps out, so that different pictures are merged."
        "options that were added after the hash";
}

/// Whether `defect` is planted: a constant without the feature `defects`.
#[cfg(not(feature = "defects"))]
#[inline(always)]
pub const fn planted(_defect: Defect) -> bool {
    false
}

/// Whether `defect` is planted: the one that `ETENDUE_DEFECT` named when it was first asked.
#[cfg(feature = "defects")]
#[inline]
pub fn planted(defect: Defect) -> bool {
    current() == Some(defect)
}

/// The planted defect, if there is one.
#[cfg(not(feature = "defects"))]
pub const fn current() -> Option<Defect> {
    None
}

/// The planted defect, if there is one. Ends the process at a name that is none: a typing error must not look like a
/// healthy renderer.
#[cfg(feature = "defects")]
#[inline]
pub fn current() -> Option<Defect> {
    static CURRENT: std::sync::LazyLock<Option<Defect>> = std::sync::LazyLock::new(|| {
        let name = std::env::var("ETENDUE_DEFECT").ok().filter(|name| !name.is_empty())?;
        let found = Defect::ALL.iter().copied().find(|d| d.name() == name);
        if found.is_none() {
            eprintln!("error: ETENDUE_DEFECT={name} is no planted defect: see src/defects.rs");
            std::process::exit(2);
        }
        found
    });
    *CURRENT
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_distinct_and_defects_described() {
        let names: HashSet<_> = Defect::ALL.iter().map(|d| d.name()).collect();
        assert_eq!(names.len(), Defect::ALL.len());
        for d in Defect::ALL {
            assert!(d.name().chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'), "{d:?}");
            assert!(d.wrong().ends_with('.') && !d.known_from().is_empty(), "{d:?}");
        }
    }

    #[test]
    #[cfg(not(feature = "defects"))]
    fn nothing_is_planted_in_an_ordinary_build() {
        const { assert!(!planted(Defect::GgxPdf2Percent) && current().is_none()) }
    }
}
