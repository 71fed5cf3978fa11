//! The killers: fast tests whose claims are sharp. Each runs against every defect, so that the matrix shows how many hold a place.

/// A test by its binary and its path in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Killer {
    /// `lib` for unit tests, else a binary under tests/.
    pub(crate) binary: &'static str,
    pub(crate) test: &'static str,
}

impl Killer {
    pub(crate) fn name(self) -> String {
        format!("{} {}", self.binary, self.test)
    }
}

const fn of(binary: &'static str, test: &'static str) -> Killer {
    Killer { binary, test }
}

pub(crate) const KILLERS: &[Killer] = &[
    of("lib", "sampling::sobol::tests::the_first_and_the_next_power_of_two_points_are_nets"),
    of("lib", "sampling::sobol::tests::slots_and_replicates_are_not_correlated"),
    of("lib", "sampling::table::tests::choices_agree_with_their_probability_at_every_boundary"),
    of("lib", "sampling::table::tests::probabilities_sum_to_one_and_zero_weights_are_never_chosen"),
    of("lib", "geometry::world::tests::placed_normals_stay_perpendicular"),
    of("lib", "texture::tests::bilinear_lookup_is_exact_at_texel_centres_and_midway"),
    of("lib", "io::gltf::texture::tests::an_uneven_scale_comes_before_rotation_and_offset"),
    of("lib", "light::punctual::tests::the_power_of_a_spot_is_its_intensity_integrated_over_directions"),
    of("lib", "film::filter::tests::inverse_is_accurate_and_monotone"),
    of("lib", "film::filter::tests::samples_follow_the_filter"),
    of("lib", "film::sums::tests::order_and_grouping_do_not_matter"),
    of("lib", "film::sums::tests::rounding_of_dim_values_is_unbiased"),
    of("lib", "film::accumulate::tests::a_crop_rounds_as_the_whole"),
    of("lib", "film::accumulate::tests::means_are_those_of_the_values"),
    of("lib", "film::accumulate::tests::order_and_shards_leave_no_trace"),
    of("lib", "film::error_estimate::tests::noise_in_the_denominator_is_corrected"),
    of("lib", "film::error_estimate::tests::relmse_and_standard_error_are_unbiased"),
    of("lib", "stats::estimate::tests::t_interval_covers_at_its_level"),
    of("lib", "stats::hypothesis::tests::tests_hold_their_level"),
    of("lib", "stats::multiple::tests::holm_steps_down"),
    of("sampling", "warps::warps_follow_their_densities"),
    of("sampling", "warps::inverses_undo_warps"),
    of("sampling", "identities::a_sample_carries_its_value_and_density"),
    of("sampling", "identities::single_precision_computes_what_double_does"),
    of("sampling", "identities::values_over_the_square_of_the_index_are_reciprocal"),
    of("sampling", "identities::densities_are_the_jacobians_of_the_maps"),
    of("sampling", "identities::the_density_of_refraction_is_the_jacobian_of_snells_law"),
    of("sampling", "inverses::sampling_undoes_inversion"),
    of("sampling", "inverses::inverted_samples_are_distributed_as_the_numbers_were"),
    of("sampling", "furnace::smooth_faces_and_white_matter_lose_nothing"),
    of("sampling", "furnace::a_white_base_under_a_white_layer_loses_nothing"),
    of("sampling", "furnace::rough_metal_reflects_what_quadrature_says"),
    of("sampling", "furnace::nearly_smooth_surfaces_scatter_like_smooth_ones"),
    of("sampling", "textbook::rough_reflection_is_the_textbooks"),
    of("sampling", "textbook::schlicks_reflectance_has_the_fifth_power"),
    of("sampling", "textbook::alpha_is_the_square_of_roughness"),
    of("sampling", "textbook::specular_strength_scales_reflection_at_every_angle"),
    of("sampling", "shading::both_walks_see_one_scattering_function"),
    of("sampling", "shading::light_does_not_leak_between_the_normals"),
    of("sampling", "shading::a_sampled_weight_is_the_value_over_the_density"),
    of("sampling", "shading::a_mirror_keeps_radiance_toward_the_light_and_flux_toward_the_camera"),
    of("sampling", "lights::directions_to_a_triangle_follow_its_density"),
    of("sampling", "lights::samples_of_a_triangle_measure_its_solid_angle"),
    of("sampling", "environments::directions_follow_the_density_and_it_integrates_to_one"),
    of("sampling", "environments::lookup_and_density_are_those_of_the_texels"),
    of("sampling", "environments::sampled_radiance_has_the_integral_of_the_map_for_its_mean"),
    of("sampling", "environments::samples_are_what_rays_find"),
    of("agreement", "closed_forms::a_closed_room_of_one_material_is_uniformly_bright"),
    of("agreement", "closed_forms::depth_counts_scattering_events"),
    of("agreement", "closed_forms::a_square_light_gives_the_irradiance_of_lamberts_formula"),
    of("agreement", "closed_forms::a_point_light_falls_off_with_the_square_of_the_distance"),
    of("agreement", "closed_forms::glass_in_a_furnace_cannot_be_seen"),
    of("agreement", "closed_forms::alpha_means_the_same_to_every_method"),
    of("agreement", "enclosures::a_room_in_thermal_equilibrium_shows_nothing"),
    of("agreement", "enclosures::a_sphere_around_a_point_light_is_uniformly_bright"),
    of("agreement", "enclosures::mirrors_in_a_row_multiply"),
    of("agreement", "environments::the_camera_sees_the_map"),
    of("agreement", "environments::a_plane_under_a_constant_map_shows_its_reflectance"),
    of("agreement", "environments::a_map_and_a_lamp_are_both_found"),
    of("agreement", "exact::pixels_lie_where_the_camera_looks"),
    of("agreement", "exact::the_edge_of_a_spot_is_the_square_of_a_ramp"),
    of("agreement", "exact::a_masked_screen_shades_where_it_is_there"),
    of("agreement", "exact::a_single_sided_lamp_is_dark_behind"),
    of("agreement", "exact::glass_absorbs_by_the_way_through_it"),
    of("agreement", "invariance::a_scene_far_away_or_of_another_size_renders_alike"),
    of("agreement", "invariance::instances_and_copies_are_the_same_scene"),
    of("agreement", "invariance::shared_and_moved_normals_are_the_same"),
    of("agreement", "lamps::a_speck_of_a_millionth_is_a_point_light"),
    of("agreement", "lamps::a_sphere_gives_the_irradiance_of_its_disk"),
    of("agreement", "textures::a_textured_lamp_lights_alike_by_every_method"),
    of("agreement", "textures::normal_maps_bend_where_the_specification_says"),
    of("agreement", "sides::a_mirror_shows_both_sides"),
    of("agreement", "sides::what_the_camera_does_not_see_still_throws_a_shadow"),
    of("agreement", "sides::features_are_those_of_what_is_seen"),
    of("agreement", "bidirectional::a_limit_of_depth_means_the_same"),
    of("agreement", "bidirectional::a_crop_shows_what_the_whole_does"),
    of("path", "identities::weights_are_a_partition_of_unity_and_the_fast_ones_are_the_defined_ones"),
    of("path", "identities::what_a_technique_finds_is_the_integrand_over_its_density"),
    of("lib", "film::splats::tests::a_crop_sees_what_falls_on_it"),
    of("lib", "film::splats::tests::splats_keep_their_light"),
    of("accel", "segments::a_segment_meets_neither_of_the_surfaces_that_it_joins"),
];
