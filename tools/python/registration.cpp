// SPDX-License-Identifier: MIT

#include "tools/python/registration.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/topology.h"
#include "libshape/registration/scan_fit.h"
#include "tools/python/handles.h"
#include "tools/python/jobs.h"

namespace shape::python {

using namespace internal;

namespace {

py::dict to_python(const DistanceSummary& distances)
{
    py::dict figures;
    figures["mean"] = distances.mean;
    figures["p95"] = distances.p95;
    figures["max"] = distances.max;
    return figures;
}

const char* name(FitStatus status)
{
    return status == FitStatus::Good ? "good" : status == FitStatus::Check ? "check" : "failed";
}

/// (positions, the fields of FitReport)
py::tuple fit_scan(const Doubles& pattern, const Integers& faces, const Doubles& scan,
                   const Integers& scan_faces, const std::vector<std::string>& names,
                   const Doubles& on_template, const Doubles& on_scan, const FitOptions& options)
{
    struct Fitted
    {
        ScanFit fit;
        std::vector<std::string> ignored;
    };
    const Points points = points_of(pattern);
    const Faces corners = faces_of(faces);
    const Points raw = points_of(scan);
    const Faces raw_faces = faces_of(scan_faces);
    const LandmarkPairs landmarks{names, points_of(on_template), points_of(on_scan)};
    Fitted fitted = run([=](const Progress&) {
        const Scan cleaned = clean_scan(raw, raw_faces);
        const ScanFitter fitter(Topology(corners, static_cast<int>(points.rows())), points,
                                options);
        return Fitted{fitter.fit(cleaned, landmarks), cleaned.ignored};
    });
    ScanFit& fit = fitted.fit;
    py::dict figures;
    figures["status"] = name(fit.status);
    figures["reasons"] = fit.reasons;
    figures["ignored"] = fitted.ignored;
    figures["scan_to_fit"] = to_python(fit.scan_to_fit);
    figures["fit_to_scan"] = to_python(fit.fit_to_scan);
    figures["diagonal"] = fit.diagonal;
    figures["strain_rms"] = fit.strain_rms;
    figures["growth_low"] = fit.growth_low;
    figures["growth_high"] = fit.growth_high;
    figures["folded_faces"] = fit.folded_faces;
    figures["unclaimed_share"] = fit.unclaimed_share;
    figures["contested_vertices"] = fit.contested_vertices;
    figures["turned_faces"] = fit.turned_faces;
    figures["scale"] = fit.scale;
    py::dict doubted;
    for (const DoubtedLandmark& landmark : fit.doubted_landmarks)
        doubted[py::str(landmark.name)] = landmark.off;
    figures["doubted_landmarks"] = doubted;
    figures["landmark_errors"] = array_of(std::move(fit.landmark_errors));
    figures["distance"] = array_of(std::move(fit.distance));
    figures["growth"] = array_of(std::move(fit.growth));
    py::array_t<bool> seen(static_cast<py::ssize_t>(fit.seen.size()));
    std::copy(fit.seen.begin(), fit.seen.end(), seen.mutable_data());
    figures["seen"] = seen;
    return py::make_tuple(array_of(std::move(fit.points)), figures);
}

FitOptions fit_options(double smoothness, double growth_smoothness, double landmark_tolerance,
                       bool search, const std::vector<std::string>& boundaries)
{
    return {.smoothness = smoothness,
            .growth_smoothness = growth_smoothness,
            .landmark_tolerance = landmark_tolerance,
            .search_start = search,
            .boundaries = boundaries};
}

/// (V, F, name) of a file whose triangles need not be a surface.
py::tuple read_scan(const std::string& path)
{
    NamedMesh mesh = run([=](const Progress&) { return read_mesh(path, {.triangulate = true}); });
    return py::make_tuple(array_of(std::move(mesh.points)), array_of_faces(mesh.faces), mesh.name);
}

} // namespace

void add_registration(py::module_& module)
{
    py::class_<FitOptions>(module, "FitOptions").def(py::init(&fit_options));
    module.def("fit_scan", fit_scan);
    module.def("read_scan", read_scan);
}

} // namespace shape::python
