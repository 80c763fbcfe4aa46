// SPDX-License-Identifier: MIT

#include "libshape/io/landmark_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/json_fault.h"
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

/// A table without `scan` is of one mesh; that it is of several shows by a column of their names, or by a
/// landmark that occurs twice.
void check_is_of_one_mesh(const std::vector<std::string>& columns,
                          const std::vector<Landmark>& landmarks, const std::string& path)
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
    for (const Landmark& landmark : landmarks)
        if (!names.insert(landmark.name).second) {
            std::string list;
            for (const std::string& column : columns)
                list += (list.empty() ? "" : ", ") + column;
            throw InvalidInput(
                join(path, ": landmark '", landmark.name,
                     "' occurs twice, and there is no column 'scan' (columns: ", list, ")", hint));
        }
}

std::vector<Landmark> read_csv(const std::string& path)
{
    const Table table = read_table(path);
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
    std::vector<Landmark> landmarks;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
        const std::vector<std::string>& cells = table.rows[i];
        const std::string place = join(path, ", row ", i + 1);
        Landmark landmark;
        landmark.name = cells[name];
        if (scan >= 0)
            landmark.scan = without_mesh_ending(cells[to_size(scan)]);
        if (vertex >= 0 && !cells[to_size(vertex)].empty()) {
            const double number = parse_number(cells[to_size(vertex)], place);
            if (!(number >= 0.0 && number < 1e9 && number == std::floor(number)))
                throw InvalidInput(
                    join(place, ": vertex is ", number, ", must be a whole number >= 0"));
            landmark.vertex = static_cast<int>(number);
        }
        const bool has_position = !cells[axes[0]].empty() || landmark.vertex < 0;
        for (int k = 0; has_position && k < 3; ++k)
            landmark.position[k] = parse_number(cells[axes[k]], place);
        landmarks.push_back(std::move(landmark));
    }
    if (scan < 0)
        check_is_of_one_mesh(table.columns, landmarks, path);
    return landmarks;
}

/// "# CoordinateSystem = LPS", then lines id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,...
std::vector<Landmark> read_fcsv(const std::string& path)
{
    std::istringstream lines(read_file(path, size_limit));
    std::string line;
    std::string system = "RAS"; // as Slicer takes a file that does not say
    std::vector<Landmark> landmarks;
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
        if (line.empty())
            continue;
        std::vector<std::string> cells;
        std::istringstream row(line);
        for (std::string cell; std::getline(row, cell, ',');)
            cells.push_back(cell);
        const std::string place = join(path, ", line ", number);
        if (cells.size() < 4)
            throw InvalidInput(join(place, ": ", cells.size(), " cells; id,x,y,z,... needs four"));
        Landmark landmark;
        landmark.name = cells.size() > 11 && !cells[11].empty() ? cells[11] : cells[0];
        for (int k = 0; k < 3; ++k)
            landmark.position[k] = parse_number(cells[to_size(k) + 1], place);
        landmark.position = to_lps(landmark.position, system, path);
        landmarks.push_back(std::move(landmark));
    }
    return landmarks;
}

std::vector<Landmark> read_markups(const std::string& path)
try {
    const auto document = nlohmann::json::parse(read_file(path, size_limit));
    std::vector<Landmark> landmarks;
    for (const auto& markup : document.at("markups")) {
        const std::string system = markup.value("coordinateSystem", "LPS");
        for (const auto& point : markup.at("controlPoints")) {
            if (point.value("positionStatus", "defined") != "defined")
                continue;
            Landmark landmark;
            landmark.name = point.value("label", point.value("id", ""));
            const auto position = point.at("position").get<std::array<double, 3>>();
            landmark.position = to_lps({position[0], position[1], position[2]}, system, path);
            landmarks.push_back(std::move(landmark));
        }
    }
    return landmarks;
} catch (const nlohmann::json::exception& error) {
    throw InvalidInput(join(path, ": not a markups file of 3D Slicer: ", json_fault(error.what())));
}

} // namespace

bool is_landmark_file(const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    return name.ends_with(".csv") || name.ends_with(".fcsv") || name.ends_with(".mrk.json");
}

std::vector<Landmark> read_landmarks(const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    std::vector<Landmark> landmarks;
    if (name.ends_with(".fcsv"))
        landmarks = read_fcsv(path.string());
    else if (name.ends_with(".mrk.json"))
        landmarks = read_markups(path.string());
    else if (name.ends_with(".csv"))
        landmarks = read_csv(path.string());
    else
        throw InvalidInput(
            join(path.string(), ": landmarks are read from .csv, .fcsv and .mrk.json files"));
    if (landmarks.empty())
        throw InvalidInput(join(path.string(), ": no landmark"));
    for (const Landmark& landmark : landmarks)
        if (!landmark.position.allFinite())
            throw InvalidInput(
                join(path.string(), ": landmark '", landmark.name, "' is not finite"));
    return landmarks;
}

} // namespace shape
