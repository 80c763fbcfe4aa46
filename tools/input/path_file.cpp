// SPDX-License-Identifier: MIT

#include "tools/input/path_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/json_depth.h"
#include "libshape/io/file/json_fault.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

using Eigen::MatrixX2d;
using Eigen::Vector2d;

constexpr std::uint64_t largest_file = std::uint64_t{1} << 26;

/// Reads one JSON value; `place` starts its messages.
class Value
{
public:
    Value(const nlohmann::json& json, std::string place) : json_(json), place_(std::move(place)) {}

    [[nodiscard]] double number() const
    {
        if (!json_.is_number())
            fail("must be a number");
        return json_.get<double>();
    }
    [[nodiscard]] std::vector<Value> list() const
    {
        if (!json_.is_array() || json_.empty())
            fail("must be a list that is not empty");
        std::vector<Value> items;
        for (std::size_t i = 0; i < json_.size(); ++i)
            items.emplace_back(json_[i], join(place_, "[", i, "]"));
        return items;
    }
    [[nodiscard]] std::vector<double> numbers() const
    {
        std::vector<double> values;
        for (const Value& item : list())
            values.push_back(item.number());
        return values;
    }
    [[nodiscard]] Vector2d pair() const
    {
        const std::vector<double> values = numbers();
        if (values.size() != 2)
            fail("must be a pair of numbers");
        return {values[0], values[1]};
    }
    [[nodiscard]] MatrixX2d points() const
    {
        const std::vector<Value> items = list();
        MatrixX2d rows(static_cast<Eigen::Index>(items.size()), 2);
        for (std::size_t i = 0; i < items.size(); ++i)
            rows.row(static_cast<Eigen::Index>(i)) = items[i].pair().transpose();
        return rows;
    }
    [[nodiscard]] std::int64_t count(std::int64_t most) const
    {
        if (!json_.is_number_integer() || json_ < 2 || json_ > most)
            fail(join("must be an integer in [2, ", most, "]"));
        return json_.get<std::int64_t>();
    }
    template <class T>
    [[nodiscard]] T choice(const std::vector<std::pair<std::string, T>>& choices) const
    {
        std::string known;
        for (const auto& [name, value] : choices) {
            if (json_ == name)
                return value;
            known += (known.empty() ? "" : ", ") + name;
        }
        fail("must be one of " + known);
    }

private:
    [[noreturn]] void fail(const std::string& rule) const
    {
        throw InvalidInput(join(place_, " is ", json_.dump().substr(0, 80), ", ", rule));
    }

    const nlohmann::json& json_;
    std::string place_;
};

/// What a path file may say; each key once, and not if an option says it.
class PathFile
{
public:
    PathFile(PathDescription& path, std::string file) : path_(path), file_(std::move(file)) {}

    void read()
    {
        const std::string text = read_file(file_, largest_file);
        if (!is_shallow_json(text))
            throw InvalidInput(
                join(file_, ": lists are nested deeper than ", deepest_json, " levels"));
        std::vector<std::string> seen;
        const auto refuse_repeats = [&](int depth, nlohmann::json::parse_event_t event,
                                        nlohmann::json& parsed) {
            if (event == nlohmann::json::parse_event_t::key && depth == 1) {
                const auto key = parsed.get<std::string>();
                if (std::find(seen.begin(), seen.end(), key) != seen.end())
                    throw InvalidInput(join(file_, ": key '", key, "' occurs twice"));
                seen.push_back(key);
            }
            return true;
        };
        nlohmann::json json;
        try {
            json = nlohmann::json::parse(text, refuse_repeats);
        } catch (const nlohmann::json::exception& error) {
            throw InvalidInput(join(file_, ": ", json_fault(error.what())));
        }
        if (!json.is_object())
            throw InvalidInput(join(file_, ": must be a JSON object"));
        for (const auto& [key, value] : json.items())
            read_key(key, Value(value, join(file_, ": ", key)));
    }

private:
    void read_key(const std::string& key, const Value& value)
    {
        if (key == "path")
            set(path_.kind, value.choice(path_kinds()), key);
        else if (key == "spline")
            set(path_.spline, value.choice(spline_kinds()), key);
        else if (key == "frames")
            set(path_.frames, value.count(most_frames), key);
        else if (key == "range")
            set(path_.range, value.pair(), key);
        else if (key == "grid") {
            (void)value.pair();
            set(path_.grid,
                Vector2d(value.list()[0].count(most_rows), value.list()[1].count(most_rows)), key);
        } else if (key == "at")
            set(path_.at, value.points(), key);
        else if (key == "track")
            set(path_.track, value.points(), key);
        else if (key == "polygon")
            set(path_.polygon, value.points(), key);
        else if (key == "weights") {
            refuse_both(!path_.weights.empty(), key);
            for (const Value& item : value.list())
                path_.weights.push_back(item.numbers());
        } else
            throw InvalidInput(join(file_, ": unknown key '", key,
                                    "'; there are path, spline, frames, range, grid, at, track, "
                                    "polygon, weights"));
    }

    template <class T>
    void set(std::optional<T>& field, const T& value, const std::string& key)
    {
        refuse_both(field.has_value(), key);
        field = value;
    }
    void set(MatrixX2d& field, const MatrixX2d& value, const std::string& key)
    {
        refuse_both(field.rows() > 0, key);
        field = value;
    }
    void refuse_both(bool both, const std::string& key) const
    {
        if (both)
            throw UsageError(join("--", key, " and the key '", key, "' of ", file_,
                                  " say the same thing; give one"));
    }

    PathDescription& path_;
    std::string file_;
};

} // namespace

const std::vector<std::pair<std::string, PathKind>>& path_kinds()
{
    static const std::vector<std::pair<std::string, PathKind>> kinds{
        {"line", PathKind::Line},
        {"bilinear", PathKind::Bilinear},
        {"polygon", PathKind::Polygon},
        {"spline", PathKind::Spline}};
    return kinds;
}

const std::vector<std::pair<std::string, SplineKind>>& spline_kinds()
{
    static const std::vector<std::pair<std::string, SplineKind>> kinds{
        {"catmull-rom", SplineKind::CatmullRom}, {"b-spline", SplineKind::BSpline}};
    return kinds;
}

void read_path_file(const std::string& file, PathDescription& description)
{
    PathFile(description, file).read();
}

} // namespace shape::tools
