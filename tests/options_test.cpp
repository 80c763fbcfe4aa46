// SPDX-License-Identifier: MIT

// Every field of every options struct that has a rule, and every function that takes one.

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/conformal/disc_map.h"
#include "libshape/conformal/flat_metric.h"
#include "libshape/conformal/scale_factors.h"
#include "libshape/conformal/sphere_map.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/contact/contact_separation.h"
#include "libshape/embedding/dihedral/coherent_path.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/embedder.h"
#include "libshape/embedding/energy/descent.h"
#include "libshape/embedding/energy/eight_lane_descent.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/multiscale/multiscale_hierarchy.h"
#include "libshape/embedding/multiscale/patch_registration.h"
#include "libshape/embedding/path/path_follower.h"
#include "libshape/embedding/repair/fold_regions.h"
#include "libshape/embedding/repair/hot_spots.h"
#include "libshape/embedding/repair/region_repair.h"
#include "libshape/embedding/sequence_jumps.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/io/gltf_file.h"
#include "libshape/io/model_file.h"
#include "libshape/linalg/lbfgs.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/difference.h"
#include "libshape/model/model_quality.h"
#include "libshape/model/shape_model.h"
#include "libshape/model/streamed_distances.h"
#include "libshape/model/streamed_effect.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/model/streamed_groups.h"
#include "libshape/registration/growth_energy.h"
#include "libshape/registration/scan_fit.h"
#include "libshape/registration/synthetic_scan.h"
#include "libshape/report/picture.h"
#include "libshape/report/render.h"
#include "libshape/statistics/block_krylov.h"
#include "libshape/statistics/bootstrap.h"
#include "libshape/statistics/linear_model.h"
#include "libshape/statistics/principal_components.h"
#include "libshape/synthetic/grids.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Fields of one struct, each given values that break its rule.
template <class Options>
class Fields
{
public:
    /// @param good  Passes; DifferenceOptions has no default that does.
    explicit Fields(std::string name, Options good = {}) : name_(std::move(name)), good_(good)
    {
        EXPECT_NO_THROW(check(good_));
    }

    template <class Value>
    const Fields& refuse(const std::string& field, Value Options::*member,
                         const std::vector<Value>& values) const
    {
        for (const Value& value : values) {
            Options options = good_;
            options.*member = value;
            const std::string message = test::message_of<InvalidInput>([&] { check(options); });
            const std::string named = name_ + "." + field;
            EXPECT_TRUE(message.starts_with(named + " ") || message.starts_with(named + "["))
                << message;
        }
        return *this;
    }
    /// > 0 and finite.
    const Fields& positive(const std::string& field, double Options::*member) const
    {
        return refuse<double>(field, member, {0.0, -1.0, nan, infinity});
    }
    /// >= 0 and finite.
    const Fields& not_negative(const std::string& field, double Options::*member) const
    {
        accept<double>(member, 0.0);
        return refuse<double>(field, member, {-1e-9, nan, infinity});
    }
    const Fields& at_least(int least, const std::string& field, int Options::*member) const
    {
        accept<int>(member, least);
        return refuse<int>(field, member, {least - 1, std::numeric_limits<int>::min()});
    }
    template <class Value>
    void accept(Value Options::*member, const Value& value) const
    {
        Options options = good_;
        options.*member = value;
        EXPECT_NO_THROW(check(options));
    }

private:
    std::string name_;
    Options good_;
};

TEST(Options, OfTheEnergyNameWhatBreaksARule)
{
    Fields<DescentOptions>("DescentOptions")
        .at_least(0, "max_linear_steps", &DescentOptions::max_linear_steps)
        .at_least(2, "first_linear_steps", &DescentOptions::first_linear_steps)
        .not_negative("decrease_tolerance", &DescentOptions::decrease_tolerance)
        .not_negative("value_tolerance", &DescentOptions::value_tolerance);
    Fields<EightLaneDescentOptions>("EightLaneDescentOptions")
        .at_least(0, "newton_steps", &EightLaneDescentOptions::newton_steps)
        .at_least(1, "linear_steps", &EightLaneDescentOptions::linear_steps)
        .at_least(0, "halvings", &EightLaneDescentOptions::halvings);
    Fields<GaussNewtonOptions>("GaussNewtonOptions")
        .at_least(0, "max_iterations", &GaussNewtonOptions::max_iterations)
        .not_negative("decrease_tolerance", &GaussNewtonOptions::decrease_tolerance)
        .positive("stiffness", &GaussNewtonOptions::stiffness);
}

TEST(Options, OfRepairsNameWhatBreaksARule)
{
    Fields<FoldRegionOptions>("FoldRegionOptions")
        .refuse<double>("fold_angle", &FoldRegionOptions::fold_angle, {0.49, -1.0, nan, infinity})
        .refuse<double>("suspect_angle", &FoldRegionOptions::suspect_angle, {-0.1, nan})
        .at_least(0, "rings", &FoldRegionOptions::rings);
    Fields<HotSpotOptions>("HotSpotOptions")
        .not_negative("seeds", &HotSpotOptions::seeds)
        .not_negative("contrast", &HotSpotOptions::contrast)
        .at_least(0, "rings", &HotSpotOptions::rings);
    Fields<RegionRepairOptions>("RegionRepairOptions")
        .at_least(0, "largest_region", &RegionRepairOptions::largest_region)
        .at_least(0, "filling_sweeps", &RegionRepairOptions::filling_sweeps)
        .at_least(0, "perturbed_starts", &RegionRepairOptions::perturbed_starts);
    EXPECT_THROW(check(RegionRepairOptions{.descent = {.linear_steps = 0}}), InvalidInput);
}

TEST(Options, OfContactsNameWhatBreaksARule)
{
    Fields<ContactGapOptions>("ContactGapOptions")
        .at_least(0, "rings", &ContactGapOptions::rings)
        .not_negative("margin", &ContactGapOptions::margin)
        .positive("step", &ContactGapOptions::step)
        .positive("deepest", &ContactGapOptions::deepest)
        .not_negative("stiffness", &ContactGapOptions::stiffness);
    Fields<ContactSeparationOptions>("ContactSeparationOptions")
        .positive("smoothness", &ContactSeparationOptions::smoothness)
        .at_least(0, "rounds", &ContactSeparationOptions::rounds)
        .at_least(0, "refinements", &ContactSeparationOptions::refinements)
        .at_least(2, "linear_steps", &ContactSeparationOptions::linear_steps)
        .positive("stretch", &ContactSeparationOptions::stretch)
        .refuse<double>("growth", &ContactSeparationOptions::growth, {0.99, nan, infinity});
    EXPECT_THROW(check(ContactSeparationOptions{.gaps = {.rings = -1}}), InvalidInput);
}

TEST(Options, OfEmbeddingsNameWhatBreaksARule)
{
    Fields<DihedralEmbeddingOptions>("DihedralEmbeddingOptions")
        .positive("smoothness", &DihedralEmbeddingOptions::smoothness)
        .not_negative("anchor", &DihedralEmbeddingOptions::anchor)
        .not_negative("position_anchor", &DihedralEmbeddingOptions::position_anchor)
        .at_least(0, "local_global_steps", &DihedralEmbeddingOptions::local_global_steps)
        .at_least(0, "max_iterations", &DihedralEmbeddingOptions::max_iterations)
        .at_least(2, "first_linear_steps", &DihedralEmbeddingOptions::first_linear_steps)
        .refuse<std::vector<int>>("repairs", &DihedralEmbeddingOptions::repairs,
                                  {{60, 24}, {-1}, {0, 5, 4}})
        .not_negative("decrease_tolerance", &DihedralEmbeddingOptions::decrease_tolerance);
    EXPECT_NO_THROW(check(dihedral_preview()));
    EXPECT_THROW(check(DihedralEmbeddingOptions{.folds = {.rings = -1}}), InvalidInput);
    EXPECT_THROW(check(DihedralEmbeddingOptions{.repair = {.filling_sweeps = -1}}), InvalidInput);
    Fields<CoherentPathOptions>("CoherentPathOptions")
        .positive("smoothness", &CoherentPathOptions::smoothness)
        .not_negative("anchor", &CoherentPathOptions::anchor)
        .not_negative("position_anchor", &CoherentPathOptions::position_anchor)
        .at_least(8, "steps", &CoherentPathOptions::steps)
        .at_least(2, "branch_steps", &CoherentPathOptions::branch_steps)
        .at_least(1, "crossing_steps", &CoherentPathOptions::crossing_steps)
        .at_least(0, "sweeps", &CoherentPathOptions::sweeps)
        .at_least(2, "sweep_steps", &CoherentPathOptions::sweep_steps);
    Fields<MultiscaleOptions>("MultiscaleOptions")
        .refuse<int>("children", &MultiscaleOptions::children, {3, 17, -1});
    EXPECT_THROW(check(MultiscaleOptions{.registration = {.passes = -1}}), InvalidInput);
    Fields<HierarchyOptions>("HierarchyOptions")
        .refuse<int>("children", &HierarchyOptions::children, {3, 17, -1});
    Fields<RegistrationOptions>("RegistrationOptions")
        .at_least(0, "passes", &RegistrationOptions::passes);
    Fields<ContinuationOptions>("ContinuationOptions")
        .positive("smoothness", &ContinuationOptions::smoothness)
        .positive("stiffness", &ContinuationOptions::stiffness)
        .not_negative("decrease_tolerance", &ContinuationOptions::decrease_tolerance)
        .at_least(0, "max_iterations", &ContinuationOptions::max_iterations);
    Fields<SettlingOptions>("SettlingOptions")
        .positive("smoothness", &SettlingOptions::smoothness)
        .positive("stiffness", &SettlingOptions::stiffness)
        .not_negative("edge_tolerance", &SettlingOptions::edge_tolerance)
        .at_least(0, "rounds", &SettlingOptions::rounds);
    Fields<PathFollowerOptions>("PathFollowerOptions")
        .at_least(1, "steps", &PathFollowerOptions::steps)
        .positive("angle_gain", &PathFollowerOptions::angle_gain)
        .positive("guidance", &PathFollowerOptions::guidance)
        .positive("smoothness", &PathFollowerOptions::smoothness)
        .positive("stiffness", &PathFollowerOptions::stiffness)
        .at_least(0, "rounds", &PathFollowerOptions::rounds)
        .not_negative("edge_tolerance", &PathFollowerOptions::edge_tolerance);
    Fields<JumpOptions>("JumpOptions")
        .positive("ratio", &JumpOptions::ratio)
        .refuse<std::size_t>("reach", &JumpOptions::reach, {0})
        .positive("least_displacement", &JumpOptions::least_displacement)
        .positive("least_bending", &JumpOptions::least_bending);
}

TEST(Options, OfAnotherEmbeddingMethodAreRefused)
{
    using Optional = std::optional<double>;
    Fields<EmbeddingOptions>("EmbeddingOptions")
        .refuse<Optional>("smoothness", &EmbeddingOptions::smoothness, {0.0, -1.0, nan, infinity})
        .refuse<Optional>("anchor", &EmbeddingOptions::anchor, {-1.0, nan, infinity})
        .refuse<std::optional<std::uint64_t>>("seed", &EmbeddingOptions::seed, {1, 7})
        .refuse<std::optional<RegistrationStart>>(
            "registration_start", &EmbeddingOptions::registration_start,
            {RegistrationStart::Incremental, RegistrationStart::Identity});
    for (const EmbeddingMethod method : {EmbeddingMethod::Closure, EmbeddingMethod::Multiscale})
        Fields<EmbeddingOptions>("EmbeddingOptions", {.method = method})
            .refuse<Optional>("smoothness", &EmbeddingOptions::smoothness, {1e-3})
            .refuse<Optional>("anchor", &EmbeddingOptions::anchor, {0.03})
            .refuse<std::optional<EmbeddingQuality>>(
                "quality", &EmbeddingOptions::quality,
                {EmbeddingQuality::Fine, EmbeddingQuality::Preview});
    Fields<EmbeddingOptions>("EmbeddingOptions", {.method = EmbeddingMethod::Closure})
        .refuse<std::optional<std::uint64_t>>("seed", &EmbeddingOptions::seed, {1});
    EXPECT_NO_THROW(check(EmbeddingOptions{.method = EmbeddingMethod::Multiscale,
                                           .registration_start = RegistrationStart::Identity,
                                           .seed = 3}));
}

TEST(Options, OfSpacesAndConformalMapsNameWhatBreaksARule)
{
    Fields<ProcrustesOptions>("ProcrustesOptions")
        .at_least(1, "max_iterations", &ProcrustesOptions::max_iterations)
        .positive("tolerance", &ProcrustesOptions::tolerance);
    Fields<SpaceOptions>("SpaceOptions")
        .refuse<double>("dihedral_weight", &SpaceOptions::dihedral_weight,
                        {-1e-9, 1.1e6, nan, infinity})
        .refuse<double>("position_weight", &SpaceOptions::position_weight,
                        {-1e-9, 1.1e6, nan, infinity})
        .accept(&SpaceOptions::position_weight, 1e6);
    Fields<SpaceOptions>("SpaceOptions", {.kind = SpaceKind::Procrustes})
        .refuse<LengthCoordinates>("coordinates", &SpaceOptions::coordinates,
                                   {LengthCoordinates::Log})
        .refuse<EdgeWeighting>("weighting", &SpaceOptions::weighting, {EdgeWeighting::Area})
        .refuse<double>("dihedral_weight", &SpaceOptions::dihedral_weight, {1.0})
        .refuse<double>("position_weight", &SpaceOptions::position_weight, {1.0});
    Fields<DiscMapOptions>("DiscMapOptions")
        .refuse<Eigen::VectorXd>("boundary_factors", &DiscMapOptions::boundary_factors,
                                 {Eigen::Vector2d(0.0, nan), Eigen::Vector2d(-infinity, 0.0)});
    Fields<ScaleFactorOptions>("ScaleFactorOptions")
        .positive("tolerance", &ScaleFactorOptions::tolerance)
        .at_least(0, "max_iterations", &ScaleFactorOptions::max_iterations);
    Fields<TriangulationRepairOptions>("TriangulationRepairOptions")
        .at_least(0, "local_rounds", &TriangulationRepairOptions::local_rounds)
        .at_least(0, "max_rounds", &TriangulationRepairOptions::max_rounds);
    Fields<SphereMapOptions>("SphereMapOptions")
        .at_least(-1, "infinite_vertex", &SphereMapOptions::infinite_vertex);
    EXPECT_THROW(check(SphereMapOptions{.repair = {.max_rounds = -1}}), InvalidInput);
}

TEST(Options, OfStatisticsAndModelsNameWhatBreaksARule)
{
    Fields<LbfgsOptions>("LbfgsOptions")
        .at_least(1, "memory", &LbfgsOptions::memory)
        .not_negative("gradient_tolerance", &LbfgsOptions::gradient_tolerance)
        .not_negative("decrease_tolerance", &LbfgsOptions::decrease_tolerance)
        .at_least(0, "max_iterations", &LbfgsOptions::max_iterations);
    Fields<BootstrapOptions>("BootstrapOptions")
        .at_least(1, "replicates", &BootstrapOptions::replicates)
        .refuse<double>("confidence", &BootstrapOptions::confidence, {0.0, 1.0, -0.5, nan});
    Fields<PermutationOptions>("PermutationOptions")
        .at_least(0, "permutations", &PermutationOptions::permutations);
    Fields<PrincipalComponentsOptions>("PrincipalComponentsOptions")
        .at_least(0, "modes", &PrincipalComponentsOptions::modes)
        .refuse<double>("variance", &PrincipalComponentsOptions::variance, {0.0, 1.01, -0.5, nan});
    Fields<PrincipalComponentsOptions>("PrincipalComponentsOptions", {.modes = 2})
        .refuse<double>("variance", &PrincipalComponentsOptions::variance, {0.9});
    Fields<ModelOptions>("ModelOptions")
        .at_least(0, "modes", &ModelOptions::modes)
        .refuse<double>("variance", &ModelOptions::variance, {0.0, 1.01, -0.5, nan});
    Fields<BlockKrylovOptions>("BlockKrylovOptions")
        .refuse<Eigen::Index>("components", &BlockKrylovOptions::components, {-1})
        .refuse<double>("variance", &BlockKrylovOptions::variance, {0.0, 1.01, -0.5, nan})
        .refuse<double>("tolerance", &BlockKrylovOptions::tolerance, {0.0, 1.0, -0.5, nan});
    EXPECT_THROW(check(StreamedDistancesOptions{.space = {.dihedral_weight = nan}}), InvalidInput);
    EXPECT_THROW(check(StreamedDistancesOptions{.ranks = {.count = 3}}), InvalidInput);
    EXPECT_THROW(check(StreamedProductsOptions{.space = {.dihedral_weight = nan}}), InvalidInput);
    EXPECT_THROW(check(StreamedGroupsOptions{.space = {.dihedral_weight = nan}}), InvalidInput);
    EXPECT_THROW(check(StreamedGroupsOptions{.permutations = {.permutations = -1}}), InvalidInput);
    EXPECT_THROW(check(StreamedGroupsOptions{.bootstrap = {.replicates = 0}}), InvalidInput);
    Fields<StreamedEffectOptions>(
        "StreamedEffectOptions",
        {{}, [](const Eigen::VectorXd& sizes) { return Eigen::MatrixXd(sizes); }})
        .refuse<std::function<Eigen::MatrixXd(const Eigen::VectorXd&)>>(
            "covariates", &StreamedEffectOptions::covariates, {nullptr});
    Fields<StreamOptions>("StreamOptions")
        .refuse<double>("tolerance", &StreamOptions::tolerance, {0.0, 1.0, -0.5, nan});
    Fields<ModelOptions>("ModelOptions", {.modes = 2})
        .refuse<double>("variance", &ModelOptions::variance, {0.9});
    EXPECT_THROW(check(ModelOptions{.space = {.dihedral_weight = nan}}), InvalidInput);
    const QualityOptions quality{.modes = {1, 3}};
    Fields<QualityOptions>("QualityOptions", quality)
        .refuse<std::vector<int>>("modes", &QualityOptions::modes, {{0}, {-1, 2}, {3, 2}, {2, 2}})
        .at_least(1, "tests", &QualityOptions::tests)
        .at_least(1, "samples", &QualityOptions::samples);
    EXPECT_THROW(check(QualityOptions{.space = {.dihedral_weight = -1.0}, .modes = {1}}),
                 InvalidInput);
    EXPECT_THROW(check(QualityOptions{.modes = {1}, .embedding = {.smoothness = 0.0}}),
                 InvalidInput);
    const DifferenceOptions difference{
        .pair_by = "id", .from_label = "a", .from_value = "x", .to_label = "a", .to_value = "y"};
    Fields<DifferenceOptions>("DifferenceOptions", difference)
        .refuse<std::string>("from_label", &DifferenceOptions::from_label, {""})
        .refuse<std::string>("to_label", &DifferenceOptions::to_label, {""})
        .refuse<std::string>("to_value", &DifferenceOptions::to_value, {"x"});
}

TEST(Options, OfPicturesFilesAndDatasetsNameWhatBreaksARule)
{
    Fields<PictureOptions>("PictureOptions")
        .at_least(0, "columns", &PictureOptions::columns)
        .refuse<int>("cell_width", &PictureOptions::cell_width, {15, 4097})
        .refuse<int>("scale", &PictureOptions::scale, {0, 5})
        .refuse<double>("value_low", &PictureOptions::value_low, {nan, -infinity})
        .refuse<double>("value_high", &PictureOptions::value_high, {0.0, -1.0, nan, infinity});
    Fields<RenderOptions>("RenderOptions")
        .refuse<int>("width", &RenderOptions::width, {0, -1, 32769})
        .refuse<int>("height", &RenderOptions::height, {0, -1, 32769})
        .refuse<Eigen::Vector2d>("centre", &RenderOptions::centre, {{nan, 0.0}, {0.0, infinity}})
        .positive("pixel_size", &RenderOptions::pixel_size)
        .not_negative("crease_angle", &RenderOptions::crease_angle);
    Fields<GlbAnimationOptions>("GlbAnimationOptions")
        .not_negative("tolerance", &GlbAnimationOptions::tolerance)
        .positive("frames_per_second", &GlbAnimationOptions::frames_per_second);
    Fields<synthetic::TubeOptions>("TubeOptions")
        .positive("length", &synthetic::TubeOptions::length)
        .positive("radius", &synthetic::TubeOptions::radius)
        .at_least(1, "vertices", &synthetic::TubeOptions::vertices)
        .positive("stretch", &synthetic::TubeOptions::stretch);
    Fields<SyntheticOptions>("SyntheticOptions")
        .at_least(0, "count", &SyntheticOptions::count)
        .at_least(0, "vertices", &SyntheticOptions::vertices);
}

template <class Act>
void expect_named(const std::string& field, const Act& act)
{
    const std::string message = test::message_of<InvalidInput>(act);
    EXPECT_EQ(message.rfind(field, 0), 0U) << message;
}

TEST(Options, AreCheckedByAllThatEmbeds)
{
    const test::TestMesh mesh = test::icosphere(1);
    const Topology& t = mesh.topology;
    const ShapePoint target = test::shape_of(t, mesh.points);
    const Eigen::VectorXd x = mesh.points.reshaped<Eigen::RowMajor>();
    LengthDihedralEnergy energy(t, target, 0.1);
    const SinglePrecisionSolve preconditioner =
        EdgeLaplacian(t, target.edge_lengths).single_precision();
    expect_named("DescentOptions.value_tolerance", [&] {
        (void)Descender(energy, preconditioner).descend(x, {.value_tolerance = nan});
    });
    expect_named("GaussNewtonOptions.stiffness", [&] {
        (void)GaussNewton(t, graded_unknowns(t, target.edge_lengths))
            .minimize(energy, x, {.stiffness = 0.0});
    });
    const RegionMesh region(t, {0});
    EightLaneEnergy eight(energy, region);
    SparseMatrix one(1, 1);
    one.insert(0, 0) = 1.0;
    one.makeCompressed();
    EightLanePoints points(region.vertices.size());
    expect_named("EightLaneDescentOptions.newton_steps",
                 [&] { (void)descend(eight, EightLaneSolve(one), points, {.newton_steps = -1}); });
    expect_named("FoldRegionOptions.rings",
                 [&] { (void)folded_regions(t, x, target.dihedral_angles, {.rings = -1}); });
    expect_named("HotSpotOptions.rings", [&] { (void)hot_spots(energy, x, {.rings = -1}); });
    expect_named("RegionRepairOptions.filling_sweeps", [&] {
        (void)repair_regions(energy, {mesh.points}, x, {}, {.filling_sweeps = -1});
    });
    expect_named("DihedralEmbeddingOptions.repairs[1]", [&] {
        (void)DihedralEmbedder(t, {mesh.points}).embed(target, {.repairs = {60, 24}});
    });
    expect_named("CoherentPathOptions.steps", [&] {
        const DihedralEmbedder embedder(t, {mesh.points});
        (void)CoherentPath(embedder, [&](double) { return target; }, {0.0, 1.0}, {.steps = 7});
    });
    expect_named("EmbeddingOptions.smoothness",
                 [&] { (void)Embedder(t, {mesh.points}, {.smoothness = nan}); });
    expect_named("EmbeddingOptions.seed", [&] { (void)Embedder(t, {mesh.points}, {.seed = 2}); });
    expect_named("MultiscaleOptions.children",
                 [&] { (void)MultiscaleEmbedder(t, mesh.points, {.children = 2}); });
    expect_named("RegistrationOptions.passes", [&] {
        (void)MultiscaleEmbedder(t, mesh.points, {.registration = {.passes = -1}});
    });
    expect_named("RegistrationOptions.passes",
                 [&] { register_patches({}, {}, nullptr, nullptr, {.passes = -1}, {}); });
    expect_named("HierarchyOptions.children",
                 [&] { (void)build_hierarchy(t, mesh.points, {.children = 2}); });
    Continuation continuation(t, target.edge_lengths);
    expect_named("ContinuationOptions.max_iterations",
                 [&] { (void)continuation.move(mesh.points, target, {.max_iterations = -1}); });
    expect_named("ContinuationOptions.decrease_tolerance", [&] {
        (void)continuation.adjust(mesh.points, target, {.decrease_tolerance = nan});
    });
    expect_named("SettlingOptions.rounds", [&] {
        (void)continuation.settle(mesh.points, target.edge_lengths, {.rounds = -1});
    });
    const auto lengths = [&](double) { return target.edge_lengths; };
    expect_named("PathFollowerOptions.guidance", [&] {
        (void)PathFollower(t, mesh.points, lengths, target.dihedral_angles, {.guidance = 0.0});
    });
    expect_named("JumpOptions.ratio", [&] { (void)find_jumps({}, {.ratio = 0.0}); });
}

TEST(Options, OfFitsAndMadeUpScans)
{
    Fields<FitOptions>("FitOptions")
        .positive("smoothness", &FitOptions::smoothness)
        .positive("growth_smoothness", &FitOptions::growth_smoothness)
        .not_negative("landmark_tolerance", &FitOptions::landmark_tolerance);
    Fields<GrowthOptions>("GrowthOptions")
        .positive("smoothness", &GrowthOptions::smoothness)
        .positive("growth_smoothness", &GrowthOptions::growth_smoothness)
        .positive("stiffness", &GrowthOptions::stiffness);
    Fields<SyntheticScanOptions>("SyntheticScanOptions")
        .refuse<int>("vertices", &SyntheticScanOptions::vertices, {-1, 1, 49})
        .not_negative("noise", &SyntheticScanOptions::noise)
        .at_least(0, "holes", &SyntheticScanOptions::holes)
        .positive("hole_radius", &SyntheticScanOptions::hole_radius)
        .refuse<double>("cut", &SyntheticScanOptions::cut, {-0.1, 0.91, nan})
        .accept(&SyntheticScanOptions::vertices, 50);
    const test::TestMesh sphere = test::icosphere(1);
    expect_named("FitOptions.smoothness",
                 [&] { ScanFitter(sphere.topology, sphere.points, {.smoothness = nan}); });
    expect_named("SyntheticScanOptions.cut",
                 [&] { (void)synthetic_scan(sphere.topology, sphere.points, {.cut = 1.0}); });
}

TEST(Options, AreCheckedByAllElse)
{
    const test::TestMesh sphere = test::icosphere(1);
    const Eigen::VectorXd lengths = edge_lengths(sphere.topology, sphere.points);
    const test::TestMesh disc = test::open_patch(4, 1);
    expect_named("DiscMapOptions.boundary_factors[0]", [&] {
        (void)map_to_plane(
            disc.topology, edge_lengths(disc.topology, disc.points),
            {.boundary_factors = Eigen::VectorXd::Constant(disc.topology.vertex_count(), nan)});
    });
    const IntrinsicTriangulation triangulation(sphere.topology, lengths);
    expect_named("ScaleFactorOptions.tolerance",
                 [&] { (void)solve_scale_factors(triangulation, {}, {}, {.tolerance = nan}); });
    expect_named("SphereMapOptions.infinite_vertex",
                 [&] { (void)map_to_sphere(sphere.topology, lengths, {.infinite_vertex = -2}); });
    expect_named("TriangulationRepairOptions.max_rounds",
                 [&] { (void)flatten_punctured_sphere(triangulation, 0, {.max_rounds = -1}); });
    expect_named("TriangulationRepairOptions.max_rounds",
                 [&] { (void)flatten_disc(triangulation, {}, {.max_rounds = -1}); });
    expect_named("ProcrustesOptions.tolerance", [&] {
        (void)procrustes_mean({sphere.points, sphere.points}, {.tolerance = nan});
    });
    const Collection collection = test::bumpy_spheres(4, 1);
    expect_named("SpaceOptions.dihedral_weight",
                 [&] { (void)make_space(collection, {.dihedral_weight = nan}); });
    expect_named("ModelOptions.modes", [&] { (void)fit_model(collection, {.modes = -1}); });
    expect_named("PrincipalComponentsOptions.modes",
                 [&] { (void)principal_components(RowMatrix::Identity(3, 3), {.modes = -1}); });
    const Grouping folds = groups_of_one(4);
    expect_named("QualityOptions.tests",
                 [&] { (void)measure_quality(collection, folds, {.modes = {1}, .tests = 0}); });
    expect_named("DifferenceOptions.from_label", [&] { (void)mean_difference(collection, {}); });
    expect_named("DifferenceOptions.from_label", [&] { (void)difference_effects(collection, {}); });
    const test::TemporaryDirectory directory;
    const ShapeModel model = fit_model(collection, {.modes = 1});
    expect_named("ModelOptions.variance",
                 [&] { write_model(directory / "m.h5", model, ModelOptions{.variance = 2.0}); });
    const Resampling resampling{groups_of_one(3), one_group(3)};
    expect_named("BootstrapOptions.replicates", [&] {
        (void)bootstrap(resampling, [](const Eigen::VectorXd& times) { return times; },
                        {.replicates = 0});
    });
    expect_named("BootstrapOptions.confidence", [&] {
        (void)variance_intervals(RowMatrix::Identity(3, 3), 1, resampling, {.confidence = 1.0});
    });
    expect_named("PermutationOptions.permutations", [&] {
        (void)test_linear_model(Eigen::MatrixXd::Identity(3, 3), Eigen::MatrixXd::Ones(3, 1),
                                Eigen::MatrixXd(3, 0), one_group(3), {.permutations = -1});
    });
    expect_named("LbfgsOptions.memory", [] {
        (void)minimize_lbfgs([](const Eigen::VectorXd&, Eigen::VectorXd&) { return 0.0; },
                             Eigen::VectorXd::Zero(1), {.memory = 0});
    });
    expect_named("PictureOptions.scale", [&] { (void)draw_collection(collection, {.scale = 0}); });
    expect_named("RenderOptions.width",
                 [&] { (void)render_mesh(sphere.topology.faces(), sphere.points, {.width = 0}); });
    expect_named("GlbAnimationOptions.tolerance", [&] {
        (void)write_glb_animation(directory / "a.glb", {sphere.points, sphere.points},
                                  sphere.topology.faces(), {.tolerance = nan});
    });
    expect_named("TubeOptions.radius", [] { (void)synthetic::tube({.radius = nan}); });
    expect_named("SyntheticOptions.count", [] { (void)make_synthetic("arm", {.count = -1}); });
}

} // namespace
} // namespace shape
