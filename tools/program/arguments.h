// SPDX-License-Identifier: MIT

#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace shape::tools {

/// Arguments that do not go together, or that cannot be read: exit code 2.
class UsageError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// Which numbers an option takes.
enum class Sign
{
    Any,
    Positive,
};

/// Adds an option that takes one finite decimal number. (CLI11 alone would take nan, inf and 0x10.)
CLI::Option* add_number(CLI::App& command, const std::string& name, double& value,
                        const std::string& description, Sign sign = Sign::Any);
CLI::Option* add_number(CLI::App& command, const std::string& name, std::optional<double>& value,
                        const std::string& description, Sign sign = Sign::Any);

/// Adds an option that takes one decimal integer in [low, high].
CLI::Option* add_integer(CLI::App& command, const std::string& name, std::int64_t& value,
                         const std::string& description, std::int64_t low,
                         std::int64_t high = std::numeric_limits<std::int64_t>::max());
CLI::Option* add_integer(CLI::App& command, const std::string& name,
                         std::optional<std::int64_t>& value, const std::string& description,
                         std::int64_t low,
                         std::int64_t high = std::numeric_limits<std::int64_t>::max());

/// Why a text is not one of the names, with the one that is spelled most like it; empty if it is one.
[[nodiscard]] std::string explain_choice(const std::string& text,
                                         const std::vector<std::string>& names);

/// What an option of one of several values is about: T of std::optional<T> too.
template <class T>
struct ChosenType
{
    using type = T;
};
template <class T>
struct ChosenType<std::optional<T>>
{
    using type = T;
};

/// Adds an option that takes one of the named values.
/// @param value  T, or std::optional<T> if it matters whether the option is given.
template <class Value>
CLI::Option* add_choice(
    CLI::App& command, const std::string& name, Value& value, const std::string& description,
    const std::vector<std::pair<std::string, typename ChosenType<Value>::type>>& choices)
{
    std::vector<std::string> names;
    for (const auto& choice : choices)
        names.push_back(choice.first);
    const auto choose = [&value, choices](const std::string& text) {
        for (const auto& choice : choices)
            if (choice.first == text)
                value = choice.second;
    };
    return command.add_option_function<std::string>(name, choose, description)
        ->check([names](const std::string& text) { return explain_choice(text, names); })
        ->option_text(CLI::detail::join(names, "|"));
}

/// The finite number that the text spells; `place` starts the message.
/// @throws UsageError if it is none.
[[nodiscard]] double read_number(const std::string& text, const std::string& place);

/// The integer in [low, high] that the text spells; `place` starts the message.
/// @throws UsageError if it is none.
[[nodiscard]] std::int64_t read_integer(const std::string& text, const std::string& place,
                                        std::int64_t low, std::int64_t high);

/// The numbers of "n1,n2,...".
/// @throws UsageError as read_number().
[[nodiscard]] std::vector<double> read_numbers(const std::string& text, const std::string& place);

/// The pieces of a text between separators, without outer blanks; one more than there are separators.
[[nodiscard]] std::vector<std::string> split(const std::string& text, char separator);

} // namespace shape::tools
