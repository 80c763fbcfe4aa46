// SPDX-License-Identifier: MIT

#include "libshape/io/landmark_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/json_depth.h"
#include "libshape/io/file/json_fault.h"
#include "libshape/io/label_file.h"
#include "libshape/io/mesh_endings.h"
#include "libshape/io/table_file.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t size_limit = std::uint64_t{64} << 20; // [byte]

/// Right and front count up in RAS, down in LPS.
Vector3d to_lps(const Vector3d& position, const std::string& system, const std::string& path)
{
    if (system == "LPS" || system == "0" || system == "1") // Slicer 4.11 and earlier wrote numbers
        return system == "0" ? Vector3d(-position[0], -position[1], position[2]) : position;
    if (system == "RAS")
        return {-position[0], -position[1], position[2]};
    throw InvalidInput(
        join(path, ": coordinate system '", system, "'; LPS and RAS are understood"));
}

/// Three coordinates, or none if all are missing.
std::optional<Vector3d> position_in(const std::array<std::string, 3>& cells,
                                    const std::string& place)
{
    std::array<std::string, 3> values;
    std::transform(cells.begin(), cells.end(), values.begin(),
                   [](const std::string& cell) { return label_value(cell); });
    const auto missing = std::count(values.begin(), values.end(), "");
    if (missing == 3)
        return std::nullopt;
    if (missing > 0)
        throw InvalidInput(
            join(place, ": ", missing, " of the three coordinates ", missing == 1 ? "is" : "are",
                 " missing; give all of them, or none where the landmark is not to be seen"));
    Vector3d position;
    for (std::size_t k = 0; k < 3; ++k)
        position[static_cast<Eigen::Index>(k)] =
            parse_number(values[k], join(place, ", ", "xyz"[k]));
    return position;
}

void add(Landmark landmark, const std::optional<Vector3d>& position, LandmarkFile& file)
{
    if (position)
        landmark.position = *position;
    (position ? file.landmarks : file.missing).push_back(std::move(landmark));
}

/// A table without `scan` is of one mesh; that it is of several shows by a column of their names, or by a
/// landmark that occurs twice.
void check_is_of_one_mesh(const std::vector<std::string>& columns, const LandmarkFile& file,
                          const std::string& path)
{
    constexpr std::array<std::string_view, 8> other_names = {
        "scan", "mesh", "file", "filename", "specimen", "subject", "id", "template"};
    const auto other = std::ranges::find_if(columns, [&](const std::string& column) {
        return std::ranges::find(other_names, lower_case(column)) != other_names.end();
    });
    const std::string hint =
        other == columns.end()
            ? "; give one with the names of the meshes"
            : join("; rename '", *other, "' to 'scan' if it has the names of the meshes");
    std::set<std::string> names;
    for (const auto* landmarks : {&file.landmarks, &file.missing})
        for (const Landmark& landmark : *landmarks)
            if (!names.insert(landmark.name).second) {
                std::string list;
                for (const std::string& column : columns)
                    list += (list.empty() ? "" : ", ") + column;
                throw InvalidInput(join(
                    path, ": landmark '", landmark.name,
                    "' occurs twice, and there is no column 'scan' (columns: ", list, ")", hint));
            }
}

LandmarkFile read_csv(const std::string& path)
{
    Table table = read_table(path);
    for (std::string& column : table.columns)
        column = label_name(column);
    const auto find = [&](const char* name) {
        const auto found = std::find(table.columns.begin(), table.columns.end(), name);
        return found == table.columns.end() ? -1 : found - table.columns.begin();
    };
    const auto column = [&](const char* name) {
        const auto found = find(name);
        if (found < 0)
            throw InvalidInput(join(path, ": no column '", name,
                                    "'; landmarks need name, x, y, z and may have scan, vertex"));
        return to_size(found);
    };
    const std::size_t name = column("name");
    const std::size_t axes[3] = {column("x"), column("y"), column("z")};
    const auto scan = find("scan"), vertex = find("vertex");
    LandmarkFile file;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
        const std::vector<std::string>& cells = table.rows[i];
        if (std::all_of(cells.begin(), cells.end(),
                        [](const std::string& cell) { return label_name(cell).empty(); }))
            continue; // as spreadsheets write below a table
        const std::string place = join(path, ", row ", i + 1);
        Landmark landmark;
        landmark.name = label_name(cells[name]);
        if (scan >= 0)
            landmark.scan = label_name(without_mesh_ending(label_name(cells[to_size(scan)])));
        const std::string number = vertex >= 0 ? label_value(cells[to_size(vertex)]) : "";
        if (!number.empty()) {
            const double value = parse_number(number, join(place, ", vertex"));
            if (!(value >= 0.0 && value < 1e9 && value == std::floor(value)))
                throw InvalidInput(
                    join(place, ": vertex is ", value, ", must be a whole number >= 0"));
            landmark.vertex = static_cast<int>(value);
        }
        add(std::move(landmark),
            position_in({cells[axes[0]], cells[axes[1]], cells[axes[2]]}, place), file);
    }
    if (scan < 0)
        check_is_of_one_mesh(table.columns, file, path);
    return file;
}

/// Cells of a line, as Slicer quotes them: a cell that begins with a quote ends with one and has its own twice.
std::vector<std::string> slicer_cells(const std::string& line)
{
    std::vector<std::string> cells(1);
    bool is_quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (is_quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
            cells.back() += line[++i];
        else if (c == '"' && (is_quoted || cells.back().empty()))
            is_quoted = !is_quoted;
        else if (c == ',' && !is_quoted)
            cells.emplace_back();
        else
            cells.back() += c;
    }
    return cells;
}

/// "# CoordinateSystem = LPS", then lines id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,node and, from Slicer 5 on,
/// whether the position is undefined (0), a preview (1), defined (2) or missing (3).
LandmarkFile read_fcsv(const std::string& path)
{
    constexpr std::size_t label = 11, status = 14;
    std::istringstream lines(read_file(path, size_limit));
    std::string line;
    std::string system = "RAS"; // as Slicer takes a file that does not say
    LandmarkFile file;
    for (int number = 1; std::getline(lines, line); ++number) {
        if (!line.empty() && line.back() == '\r')
            line.pop_back();
        if (line.starts_with('#')) {
            const auto equals = line.find('=');
            if (line.find("CoordinateSystem") != std::string::npos && equals != std::string::npos) {
                system = line.substr(equals + 1);
                std::erase(system, ' ');
            }
            continue;
        }
        if (label_name(line).empty())
            continue;
        const std::vector<std::string> cells = slicer_cells(line);
        const std::string place = join(path, ", line ", number);
        if (cells.size() < 4)
            throw InvalidInput(join(place, ": ", cells.size(), " cells; id,x,y,z,... needs four"));
        Landmark landmark;
        landmark.name = label_name(cells.size() > label ? cells[label] : "");
        if (landmark.name.empty())
            landmark.name = label_name(cells[0]);
        const std::string stated = cells.size() > status ? label_name(cells[status]) : "";
        std::optional<Vector3d> position;
        if (stated != "0" && stated != "1" && stated != "3")
            position = position_in({cells[1], cells[2], cells[3]}, place);
        if (position)
            position = to_lps(*position, system, path);
        add(std::move(landmark), position, file);
    }
    return file;
}

/// Slicer writes "" for a position that is not defined; others leave it out, or write null.
bool is_missing(const nlohmann::json& position)
{
    const auto is_nothing = [](const nlohmann::json& value) {
        return value.is_null() ||
               (value.is_string() && label_value(value.get<std::string>()).empty());
    };
    return is_nothing(position) || (position.is_array() && position.size() == 3 &&
                                    std::all_of(position.begin(), position.end(), is_nothing));
}

LandmarkFile read_markups(const std::string& path)
try {
    const std::string text = read_file(path, size_limit);
    if (!is_shallow_json(text))
        throw InvalidInput(join(path, ": not a markups file of 3D Slicer: lists lie more than ",
                                deepest_json, " deep in each other"));
    const auto document = nlohmann::json::parse(text);
    LandmarkFile file;
    for (const auto& markup : document.at("markups")) {
        const std::string system = markup.value("coordinateSystem", "LPS");
        for (const auto& point : markup.at("controlPoints")) {
            Landmark landmark;
            landmark.name = label_name(point.value("label", ""));
            if (landmark.name.empty())
                landmark.name = label_name(point.value("id", ""));
            std::optional<Vector3d> position;
            if (point.value("positionStatus", "defined") == "defined" &&
                point.contains("position") && !is_missing(point["position"])) {
                const auto at = point["position"].get<std::array<double, 3>>();
                position = to_lps({at[0], at[1], at[2]}, system, path);
            }
            add(std::move(landmark), position, file);
        }
    }
    return file;
} catch (const nlohmann::json::exception& error) {
    throw InvalidInput(join(path, ": not a markups file of 3D Slicer: ", json_fault(error.what())));
}

} // namespace

bool is_landmark_file(const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    return name.ends_with(".csv") || name.ends_with(".fcsv") || name.ends_with(".mrk.json");
}

LandmarkFile read_landmarks(const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    LandmarkFile file;
    if (name.ends_with(".fcsv"))
        file = read_fcsv(path.string());
    else if (name.ends_with(".mrk.json"))
        file = read_markups(path.string());
    else if (name.ends_with(".csv"))
        file = read_csv(path.string());
    else
        throw InvalidInput(
            join(path.string(), ": landmarks are read from .csv, .fcsv and .mrk.json files"));
    if (file.landmarks.empty() && file.missing.empty())
        throw InvalidInput(join(path.string(), ": no landmark"));
    for (const Landmark& landmark : file.landmarks)
        if (!landmark.position.allFinite())
            throw InvalidInput(
                join(path.string(), ": landmark '", landmark.name, "' is not finite"));
    return file;
}

} // namespace shape
