// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/hdf5/file_content.h"
#include "libshape/io/hdf5/isolation.h"

namespace shape::internal {
namespace {

constexpr std::uint64_t largest_hdf5_file = std::uint64_t{1} << 50;

using IntMatrix = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// "(3, 0, 1)": the position of a value in row-major order.
std::string print_position(const Extents& extents, Eigen::Index index)
{
    std::string text = ")";
    for (auto length = extents.rbegin(); length != extents.rend(); ++length) {
        text.insert(0, join(length == std::prev(extents.rend()) ? "" : ", ", index % *length));
        index /= *length;
    }
    return "(" + text;
}

/// The text up to its padding.
std::string unpadded(std::string text)
{
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

/// All rows, some at a time: what is fetched stands beside what is made of it.
void read_all(const StoredRows& rows, RowMatrix& values)
{
    const Eigen::Index step =
        std::max<Eigen::Index>(1, (Eigen::Index{32} << 20) / (8 * rows.size()));
    for (Eigen::Index first = 0; first < rows.count(); first += step) {
        std::vector<Eigen::Index> wanted(to_size(std::min(step, rows.count() - first)));
        std::iota(wanted.begin(), wanted.end(), first);
        rows.unpack(*rows.fetch(std::move(wanted)), [&](std::size_t i) {
            return values.row(first + static_cast<Eigen::Index>(i)).data();
        });
    }
}

bool begins_as_hdf5(const std::filesystem::path& path, std::uint64_t offset)
{
    std::array<char, 8> signature{};
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset)).read(signature.data(), signature.size());
    return std::string_view(signature.data(), signature.size()) == "\x89HDF\r\n\x1a\n";
}

} // namespace

/// What the file holds. Nothing of it is trusted: a process that HDF5 has led astray may have made it.
struct Hdf5File::State
{
    std::string path;
    std::uint64_t size; ///< [byte]
    FileContent content;

    [[noreturn]] void fail(const std::string& name, const std::string& rule) const
    {
        throw InvalidInput(join(path, ": ", name, ": ", rule));
    }

    template <class Value>
    [[nodiscard]] const Value& get(const std::string& name, const Found<Value>& found) const
    {
        if (!found.refusal.empty())
            fail(name, found.refusal);
        return found.value;
    }

    /// The object, if all groups on the way and it itself exist, as plain members of this file.
    [[nodiscard]] const StoredObject* find(const std::string& name) const
    {
        std::string group = "/";
        for (std::size_t end = name.find('/', 1); true; end = name.find('/', end + 1)) {
            const std::string prefix = name.substr(0, end);
            if (const auto listed = content.groups.find(group); listed != content.groups.end())
                (void)get(name, listed->second);
            const auto object = content.objects.find(prefix);
            if (object == content.objects.end())
                return nullptr;
            if (!object->second.refusal.empty())
                fail(name, object->second.refusal);
            if (end == std::string::npos)
                return &object->second;
            group = prefix;
        }
    }

    /// Its declaration keeps all rules.
    [[nodiscard]] const StoredDataset& dataset(const std::string& name) const
    {
        const StoredObject* object = find(name);
        if (object == nullptr)
            fail(name, "is missing");
        const StoredDataset& declared = get(name, object->dataset);
        if (const std::string rule = broken_rule(declared, size); !rule.empty())
            fail(name, rule);
        return declared;
    }

    void check_extents(const std::string& name, const StoredDataset& declared,
                       const Extents& expected) const
    {
        const auto& extents = declared.extents;
        const bool agree =
            std::equal(extents.begin(), extents.end(), expected.begin(), expected.end(),
                       [](Eigen::Index a, Eigen::Index b) { return b == any_length || a == b; });
        if (!agree)
            fail(name, join("is ", print_extents(extents), ", must be ", print_extents(expected)));
    }

    /// A dataset of a numeric type that must be stored as exactly that.
    [[nodiscard]] const StoredDataset& dataset(const std::string& name, const Extents& expected,
                                               StoredDataset::Type type, const char* what) const
    {
        const StoredDataset& declared = dataset(name);
        check_extents(name, declared, expected);
        if (declared.type != type)
            fail(name, join("has values of another type, must be ", what));
        if (!declared.refusal.empty())
            fail(name, declared.refusal);
        return declared;
    }

    void check_size(const std::string& name, const StoredDataset& declared) const
    {
        if (to_size(declared.count()) > largest_array / declared.value_size)
            throw LimitExceeded(join(path, ": ", name, ": has ", declared.count(),
                                     " values; at most ", largest_array,
                                     " bytes are read into memory"));
    }

    /// The bytes that were read of it.
    [[nodiscard]] const char* bytes(const std::string& name, const StoredDataset& declared,
                                    std::uint64_t expected_size) const
    {
        const auto& [begin, count] = declared.values;
        if (count != expected_size || begin > content.values.size() ||
            count > content.values.size() - begin)
            fail(name, "cannot be read, the file is damaged");
        return content.values.data() + begin;
    }

    /// Values as HDF5 read them.
    template <class Matrix>
    [[nodiscard]] Matrix values(const std::string& name, const StoredDataset& declared) const
    {
        check_size(name, declared);
        const Eigen::Index rows = declared.extents.empty() ? 1 : declared.extents.front();
        Matrix read(rows, declared.count() / rows);
        const std::uint64_t byte_count = to_size(read.size()) * sizeof(*read.data());
        std::memcpy(read.data(), bytes(name, declared, byte_count), byte_count);
        return read;
    }

    /// Where the chunks of a dataset of doubles stand.
    [[nodiscard]] ChunkTable chunk_table(const std::string& name,
                                         const StoredDataset& declared) const
    {
        ChunkTable table{.file = path, .dataset = name, .filters = declared.filters};
        std::copy(declared.extents.begin(), declared.extents.end(), table.extents.begin());
        std::copy(declared.chunk.begin(), declared.chunk.end(), table.chunk_extents.begin());
        if (declared.layout == StoredDataset::Layout::Chunked) {
            table.chunks.resize(to_size(declared.chunk_count()));
            const std::uint64_t byte_count = table.chunks.size() * sizeof(ChunkTable::Chunk);
            std::memcpy(table.chunks.data(), bytes(name, declared, byte_count), byte_count);
        } else { // row by row, as they stand one after the other
            const auto& [rows, across, deep] = table.extents;
            table.chunk_extents = {1, across, deep};
            const std::uint64_t row_size = sizeof(double) * to_size(across * deep);
            if (!lies_in_file({declared.offset, to_size(rows) * row_size, 0}, size))
                fail(name, "has no values, or such beyond the end of the file, or in its header");
            for (std::uint64_t i = 0; i < to_size(rows); ++i)
                table.chunks.push_back({declared.offset + i * row_size, row_size, 0});
        }
        for (const ChunkTable::Chunk& chunk : table.chunks)
            if (!lies_in_file(chunk, size))
                fail(name, "has values beyond the end of the file");
        return table;
    }

    [[nodiscard]] const StoredAttribute* find_attribute(const std::string& name) const
    {
        const auto& all = get("attribute " + name, content.attributes);
        const auto place = std::ranges::find(all, name, &StoredAttribute::name);
        return place == all.end() ? nullptr : &*place;
    }

    [[nodiscard]] const StoredAttribute& attribute(const std::string& name) const
    {
        const StoredAttribute* found = find_attribute(name);
        if (found == nullptr)
            fail("attribute " + name, "is missing");
        return *found;
    }
};

Hdf5File::Hdf5File(const std::filesystem::path& path)
{
    const std::uint64_t size = checked_file_size(path, largest_hdf5_file);
    if (!begins_as_hdf5(path, 0)) {
        for (std::uint64_t user_block = 512; user_block < size; user_block *= 2)
            if (begins_as_hdf5(path, user_block))
                throw InvalidInput(join(path.string(), ": has a user block of ", user_block,
                                        " bytes, which is not read; take it away (`h5unjam`)"));
        throw InvalidInput(path.string() + ": is not an HDF5 file");
    }
    state_.reset(new State{path.string(), size, read_content_isolated_if_wanted(path, size)});
    if (!state_->content.refusal.empty())
        throw InvalidInput(join(path.string(), ": ", state_->content.refusal));
}

Hdf5File::~Hdf5File() = default;

const std::string& Hdf5File::path() const
{
    return state_->path;
}

bool Hdf5File::has(const std::string& name) const
{
    return state_->find(name) != nullptr;
}

std::vector<std::string> Hdf5File::members(const std::string& group) const
{
    if (group != "/" && !has(group))
        return {};
    const auto listed = state_->content.groups.find(group);
    if (listed == state_->content.groups.end())
        fail(group, "is nested deeper than is read");
    return state_->get(group, listed->second);
}

bool Hdf5File::is_compressed(const std::string& name) const
{
    return state_->dataset(name).is_compressed();
}

StoredRows Hdf5File::rows(const std::string& name, const Extents& expected) const
{
    return StoredRows(state_->chunk_table(
        name, state_->dataset(name, expected, StoredDataset::Type::Float64, "float64")));
}

RowMatrix Hdf5File::numbers(const std::string& name, const Extents& expected) const
{
    const StoredDataset& stored =
        state_->dataset(name, expected, StoredDataset::Type::Float64, "float64");
    if (stored.layout != StoredDataset::Layout::Compact) {
        state_->check_size(name, stored);
        const StoredRows stored_rows(state_->chunk_table(name, stored));
        RowMatrix values(stored_rows.count(), stored_rows.size());
        read_all(stored_rows, values);
        return values;
    }
    auto values = state_->values<RowMatrix>(name, stored);
    const double* const bad = std::find_if(values.data(), values.data() + values.size(),
                                           [](double value) { return !std::isfinite(value); });
    if (bad != values.data() + values.size())
        fail(name, join("value ", print_position(stored.extents, bad - values.data()), " is ", *bad,
                        ", must be finite"));
    return values;
}

IntMatrix Hdf5File::integers(const std::string& name, const Extents& expected) const
{
    return state_->values<IntMatrix>(
        name, state_->dataset(name, expected, StoredDataset::Type::Int32, "int32"));
}

std::vector<std::string> Hdf5File::strings(const std::string& name, Eigen::Index expected) const
{
    const StoredDataset& stored = state_->dataset(name);
    state_->check_extents(name, stored, {expected});
    if (stored.type != StoredDataset::Type::FixedString)
        fail(name, "must hold strings of fixed length");
    if (!stored.refusal.empty())
        fail(name, stored.refusal);
    state_->check_size(name, stored);
    const std::uint64_t byte_count = to_size(stored.count()) * stored.value_size;
    const char* const packed = state_->bytes(name, stored, byte_count);
    std::vector<std::string> strings;
    for (std::uint64_t begin = 0; begin < byte_count; begin += stored.value_size) {
        std::string text = unpadded({packed + begin, stored.value_size});
        if (!is_utf8(text))
            fail(name, join("string ", strings.size(), " is not UTF-8"));
        strings.push_back(std::move(text));
    }
    return strings;
}

bool Hdf5File::has_attribute(const std::string& name) const
{
    return state_->find_attribute(name) != nullptr;
}

std::string Hdf5File::text_attribute(const std::string& name) const
{
    return unpadded(state_->get("attribute " + name, state_->attribute(name).text));
}

std::int64_t Hdf5File::integer_attribute(const std::string& name) const
{
    return state_->get("attribute " + name, state_->attribute(name).integer);
}

void Hdf5File::fail(const std::string& name, const std::string& rule) const
{
    state_->fail(name, rule);
}

} // namespace shape::internal
