// SPDX-License-Identifier: MIT

#include "tools/program/arguments.h"

#include <algorithm>
#include <charconv>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/table_file.h"
#include "tools/program/spelling.h"

namespace shape::tools {
using namespace internal;
namespace {

template <class Value>
CLI::Option* add_number_option(CLI::App& command, const std::string& name, Value& value,
                               const std::string& description, Sign sign)
{
    const auto read = [&value, name, sign](const std::string& text) {
        const double number = read_number(text, name);
        if (sign == Sign::Positive && number <= 0.0)
            throw UsageError(join(name, ": ", text, " is out of range; it must be > 0"));
        value = number;
    };
    return command.add_option_function<std::string>(name, read, description)->option_text("NUMBER");
}

template <class Value>
CLI::Option* add_integer_option(CLI::App& command, const std::string& name, Value& value,
                                const std::string& description, std::int64_t low, std::int64_t high)
{
    const auto read = [&value, name, low, high](const std::string& text) {
        value = read_integer(text, name, low, high);
    };
    return command.add_option_function<std::string>(name, read, description)
        ->option_text("INTEGER");
}

} // namespace

CLI::Option* add_number(CLI::App& command, const std::string& name, double& value,
                        const std::string& description, Sign sign)
{
    return add_number_option(command, name, value, description, sign);
}

CLI::Option* add_number(CLI::App& command, const std::string& name, std::optional<double>& value,
                        const std::string& description, Sign sign)
{
    return add_number_option(command, name, value, description, sign);
}

CLI::Option* add_integer(CLI::App& command, const std::string& name, std::int64_t& value,
                         const std::string& description, std::int64_t low, std::int64_t high)
{
    return add_integer_option(command, name, value, description, low, high);
}

CLI::Option* add_integer(CLI::App& command, const std::string& name,
                         std::optional<std::int64_t>& value, const std::string& description,
                         std::int64_t low, std::int64_t high)
{
    return add_integer_option(command, name, value, description, low, high);
}

std::string explain_choice(const std::string& text, const std::vector<std::string>& names)
{
    if (std::ranges::find(names, text) != names.end())
        return {};
    return join("'", text, "' is not one of ", CLI::detail::join(names, ", "),
                did_you_mean(text, names));
}

double read_number(const std::string& text, const std::string& place)
{
    try {
        return parse_number(text, place);
    } catch (const InvalidInput& error) {
        throw UsageError(error.what());
    }
}

std::int64_t read_integer(const std::string& text, const std::string& place, std::int64_t low,
                          std::int64_t high)
{
    const char* end = text.data() + text.size();
    std::int64_t number = 0;
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || rest != end)
        throw UsageError(join(place, ": '", text, "' is not an integer"));
    if (number < low || number > high)
        throw UsageError(join(place, ": ", number, " is out of range [", low, ", ", high, "]"));
    return number;
}

std::vector<double> read_numbers(const std::string& text, const std::string& place)
{
    std::vector<double> numbers;
    for (const std::string& piece : split(text, ','))
        numbers.push_back(read_number(piece, place));
    return numbers;
}

std::vector<std::string> split(const std::string& text, char separator)
{
    std::vector<std::string> pieces(1);
    for (const char c : text)
        if (c == separator)
            pieces.emplace_back();
        else
            pieces.back() += c;
    for (std::string& piece : pieces) {
        piece.erase(0, piece.find_first_not_of(" \t"));
        piece.erase(piece.find_last_not_of(" \t") + 1);
    }
    return pieces;
}

} // namespace shape::tools
