// SPDX-License-Identifier: MIT

#include "tools/input/repeated_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/oddities.h"
#include "libshape/statistics/close_rows.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

/// Whether a label is called as those that tell people or specimens apart: "subject", "Patient_ID", "animal no",
/// "id_person".
bool names_individuals(const std::string& label)
{
    constexpr std::array<std::string_view, 42> words = {
        // Also of German, French, Spanish and Italian, in the plural where it is not an s.
        "subject",   "subj",     "sub",      "person",   "participant", "patient",   "individual",
        "id",        "pid",      "animal",   "specimen", "donor",       "proband",   "volunteer",
        "rid",       "ptid",     "mrn",      "case",     "mouse",       "mice",      "rat",
        "indiv",     "ind",      "name",     "personen", "patienten",   "probanden", "patientin",
        "probandin", "tier",     "tiere",    "sujet",    "patiente",    "sujeto",    "paciente",
        "persona",   "soggetto", "soggetti", "paziente", "pazienti",    "individuo", "individu"};
    constexpr std::array<std::string_view, 10> ends = {"",    "s",      "id",  "no",   "nr",
                                                       "num", "number", "key", "code", "name"};
    std::string letters = lower_case(label);
    std::erase_if(letters, [](char c) {
        return static_cast<unsigned char>(c) < 0x80 && (c < 'a' || c > 'z');
    });
    const auto is_called = [&](std::string_view name) {
        return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
            return name.starts_with(word) &&
                   std::find(ends.begin(), ends.end(), name.substr(word.size())) != ends.end();
        });
    };
    const std::string_view name = letters;
    return is_called(name) || (name.starts_with("id") && is_called(name.substr(2)));
}

bool is_constant(const Eigen::MatrixXd& covariates)
{
    return covariates.cols() > 0 && covariates.rows() > 0 &&
           (covariates.rowwise() - covariates.row(0)).isZero(0.0);
}

bool has_column(const RepetitionQuestion& question, const std::string& label)
{
    return std::find(question.columns.begin(), question.columns.end(), label) !=
           question.columns.end();
}

/// Whether a covariate is the same for all meshes of a value; those without one do not count.
bool is_nested(const Eigen::VectorXd& covariate, const std::vector<std::string>& values)
{
    std::map<std::string_view, double> first;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double number = covariate[static_cast<Eigen::Index>(i)];
        if (!values[i].empty() && first.try_emplace(values[i], number).first->second != number)
            return false;
    }
    return true;
}

/// Standard deviation within the meshes of a value, over that of all meshes [1]; those without a value do not count.
/// 1, give or take chance, where values have nothing to do with the covariate.
double spread_within(const Eigen::VectorXd& covariate, const std::vector<std::string>& values)
{
    std::map<std::string_view, std::vector<double>> numbers;
    std::vector<double> all;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!values[i].empty()) {
            numbers[values[i]].push_back(covariate[static_cast<Eigen::Index>(i)]);
            all.push_back(covariate[static_cast<Eigen::Index>(i)]);
        }
    const auto squares = [](const std::vector<double>& of) {
        const Eigen::Map<const Eigen::ArrayXd> array(of.data(), std::ssize(of));
        return (array - array.mean()).square().sum();
    };
    double within = 0.0;
    for (const auto& [value, of_value] : numbers)
        within += squares(of_value);
    const auto count = static_cast<double>(all.size());
    return std::sqrt(within / (count - static_cast<double>(numbers.size())) /
                     (squares(all) / (count - 1.0)));
}

/// Whether what an analysis knows of the meshes of a value is the same; sizes, which are measured anew with every
/// mesh, may spread by this part of what they do in all.
bool is_nested(const RepetitionQuestion& question, const std::vector<std::string>& values,
               double most_spread)
{
    for (Eigen::Index k = 0; k < question.covariates.cols(); ++k) {
        const Eigen::VectorXd covariate = question.covariates.col(k);
        if (k == question.sizes ? !(spread_within(covariate, values) <= most_spread)
                                : !is_nested(covariate, values))
            return false;
    }
    return true;
}

/// Whether each value weighs as much as any other with the same covariates in the mean of their meshes; a mesh without
/// a value stands for itself.
bool are_balanced(const Eigen::MatrixXd& covariates, const std::vector<std::string>& values)
{
    std::map<std::string_view, std::size_t> counts;
    for (const std::string& value : values)
        ++counts[value];
    std::map<std::vector<double>, std::size_t> expected;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto& row = covariates.row(static_cast<Eigen::Index>(i));
        const std::size_t count = values[i].empty() ? 1 : counts[values[i]];
        if (expected.try_emplace(std::vector<double>(row.begin(), row.end()), count)
                .first->second != count)
            return false;
    }
    return true;
}

/// Whether repeated measurements of these values would change nothing.
bool are_harmless(const RepetitionQuestion& question, const std::vector<std::string>& values)
{
    return question.is_of_means && are_balanced(question.covariates, values);
}

// Set by hand. Where sizes vary as much within the things that are measured as between them, as those of a child that
// grows do, rows may be exchanged and nothing is wrong. At a half three quarters of their variance are between things.
constexpr double little_spread = 0.5;
constexpr double very_little_spread = 0.25; // where little else speaks for repeated measurements

/// How many values there are, and how many meshes have one.
struct Counts
{
    std::size_t values;
    std::size_t meshes;
};

Counts counts_of(const std::vector<std::string>& values)
{
    std::map<std::string_view, std::size_t> meshes;
    for (const std::string& value : values)
        if (!value.empty())
            ++meshes[value];
    Counts counts{meshes.size(), 0};
    for (const auto& [value, count] : meshes)
        counts.meshes += count;
    return counts;
}

/// By its name, and as many meshes as matter.
bool tells_individuals_apart(const LabelColumn& label)
{
    // Set by hand: if a tenth are second, equal measurements of others, the variance of a mean is 1.2 times what it
    // seems, and a test at 5 % errs in 7.4 %.
    constexpr std::size_t meshes_a_repeat = 10;
    const Counts counts = counts_of(label.values);
    const std::size_t repeats = counts.meshes - counts.values;
    return names_individuals(label.name) && counts.values >= 2 && repeats >= 2 &&
           meshes_a_repeat * repeats >= label.values.size();
}

/// By the number of its values alone.
bool has_small_blocks(const LabelColumn& label)
{
    // Set by hand: labels with fewer values, or with more meshes a value, are of kinds as a rule (a sex, a side, a
    // site), which are not measured again.
    constexpr std::size_t least_values = 5;
    constexpr std::size_t largest_blocks = 20;
    const Counts counts = counts_of(label.values);
    return counts.meshes == label.values.size() && counts.values >= least_values &&
           2 * counts.values <= counts.meshes && counts.values * largest_blocks >= counts.meshes;
}

/// Meshes with the same covariates.
Grouping strata_of(const Eigen::MatrixXd& covariates)
{
    std::map<std::vector<double>, std::string> names;
    std::vector<std::string> values;
    for (const auto& row : covariates.rowwise())
        values.push_back(names
                             .try_emplace(std::vector<double>(row.begin(), row.end()),
                                          std::to_string(names.size()))
                             .first->second);
    return group_by(values);
}

/// What shapes are asked about.
struct Evidence
{
    const RepetitionQuestion& question;
    const Eigen::MatrixXd& products;
    Grouping strata = strata_of(question.covariates);

    [[nodiscard]] bool is_for(const std::vector<std::string>& values) const
    {
        constexpr std::size_t least_blocks = 3; // two are two kinds as a rule; set by hand
        // Of 3,000 random labels each, none is as near among the neutral faces of ict_faces600 (the nearest: 0.61),
        // 0.03 % among all its faces and 0.6 % among poses of MakeHuman, all of these with three blocks of two.
        constexpr double near = 0.5;
        // Half as much, set by hand: what the covariate does alone may bring near.
        constexpr double very_near = 0.25;
        const Counts counts = counts_of(values);
        if (counts.meshes < values.size() || counts.values < least_blocks ||
            2 * counts.values > counts.meshes || are_harmless(question, values) ||
            !is_nested(question, values, little_spread))
            return false;
        const Grouping blocks = group_by(values);
        const double ratio = closeness(products, blocks, strata);
        if (std::isfinite(ratio))
            return ratio <= near;
        return !question.are_groups &&
               closeness(products, blocks, one_group(blocks.size())) <= very_near;
    }
};

/// What names have before their last separator; whole names have none.
std::vector<std::string> beginnings(const std::vector<std::string>& names)
{
    std::vector<std::string> result;
    for (const std::string& name : names) {
        const std::size_t end = name.find_last_of("_-. ");
        result.push_back(end == std::string::npos || end == 0 ? name : name.substr(0, end));
    }
    return result;
}

std::vector<std::string> in_words(const Grouping& sets)
{
    std::vector<std::string> values;
    for (const int set : sets.group_of)
        values.push_back(sets.names[to_size(set)]);
    return values;
}

std::vector<std::size_t> first_of(const std::vector<std::string>& values)
{
    std::vector<std::size_t> meshes;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] == values.front())
            meshes.push_back(i);
    return meshes;
}

} // namespace

std::optional<std::string> doubt_about_rows(const MeshLabels& meshes,
                                            const RepetitionQuestion& question)
{
    if (is_constant(question.covariates)) // refused later, by its name
        return std::nullopt;
    struct Suspicion
    {
        bool (*is_of)(const LabelColumn& label);
        double most_spread;
    };
    for (const auto& [is_suspect, most_spread] : {Suspicion{tells_individuals_apart, little_spread},
                                                  Suspicion{has_small_blocks, very_little_spread}})
        for (const LabelColumn& label : meshes.labels) {
            if (has_column(question, label.name) || !is_suspect(label) ||
                are_harmless(question, label.values) ||
                !is_nested(question, label.values, most_spread))
                continue;
            return join("the ", meshes.size(), " meshes are not independent if those of one ",
                        label.name, " (", counts_of(label.values).values,
                        " of them) are repeated measurements: ", question.remedy, " ", label.name);
        }
    return std::nullopt;
}

std::optional<std::string> doubt_about_close_rows(const MeshLabels& meshes,
                                                  const RepetitionQuestion& question,
                                                  const Eigen::MatrixXd& products)
{
    if (question.covariates.cols() == 0 || is_constant(question.covariates))
        return std::nullopt;
    const Evidence evidence{question, products};
    const auto doubt = [&](const std::string& which, const std::string& what_to_give) {
        return join("the ", meshes.size(), " meshes are not independent if those ", which,
                    ", are repeated measurements: ", question.remedy, " ", what_to_give);
    };
    const auto such_as_the_first = [&](const std::vector<std::string>& values) {
        return join(", such as ", list_names(meshes.names, first_of(values)), " (",
                    counts_of(values).values, " such sets)");
    };
    for (const LabelColumn& label : meshes.labels)
        if (!has_column(question, label.name) && evidence.is_for(label.values))
            return doubt(join("of one ", label.name, " (", counts_of(label.values).values,
                              " of them), whose shapes are much alike"),
                         label.name);
    const std::vector<std::string> begun = beginnings(meshes.names);
    if (evidence.is_for(begun))
        return doubt(
            "whose names begin alike and whose shapes are much alike" + such_as_the_first(begun),
            question.unnamed);
    const std::optional<Grouping> sets = single_linkage_sets(products);
    if (!sets)
        return std::nullopt;
    const std::vector<std::string> members = in_words(*sets);
    if (evidence.is_for(members))
        return doubt("whose shapes are much alike" + such_as_the_first(members), question.unnamed);
    return std::nullopt;
}

bool warn_of_repeated_rows(const Session& session, const MeshLabels& meshes,
                           const RepetitionQuestion& question)
{
    const auto doubt = doubt_about_rows(meshes, question);
    if (doubt)
        session.warn(*doubt);
    return doubt.has_value();
}

void warn_of_close_rows(const Session& session, const MeshLabels& meshes,
                        const RepetitionQuestion& question, const Eigen::MatrixXd& products)
{
    if (const auto doubt = doubt_about_close_rows(meshes, question, products))
        session.warn(*doubt);
}

} // namespace shape::tools
