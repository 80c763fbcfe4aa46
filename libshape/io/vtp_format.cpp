// SPDX-License-Identifier: MIT

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <pugixml.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/io/vtk_values.h"

// XML polydata of VTK: arrays as text, in base 64, or behind the XML as they are; perhaps compressed.

namespace shape::internal {
namespace {

constexpr std::ptrdiff_t most_tags = 100'000; ///< Each takes a hundred bytes.

/// The numbers of base 64 from `text`, at most `most` bytes of them. Padding ends a part, and the next
/// one follows at once, as VTK writes its heads and blocks.
std::string decode_base64(std::string_view text, std::size_t most)
{
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        int value = 0;
        if (c >= 'A' && c <= 'Z')
            value = c - 'A';
        else if (c >= 'a' && c <= 'z')
            value = c - 'a' + 26;
        else if (c >= '0' && c <= '9')
            value = c - '0' + 52;
        else if (c == '+')
            value = 62;
        else if (c == '/')
            value = 63;
        else if (c == '=') {
            count = 0;
            bits = 0;
            continue;
        } else if (c == ' ' || c == '\n' || c == '\r' || c == '\t')
            continue;
        else
            break;
        bits = (bits << 6U) | static_cast<std::uint32_t>(value);
        count += 6;
        if (count >= 8) {
            count -= 8;
            if (bytes.size() == most)
                break;
            bytes += static_cast<char>((bits >> static_cast<unsigned>(count)) & 0xffU);
        }
    }
    return bytes;
}

class VtpReader
{
public:
    VtpReader(std::string_view content, std::string path) : path_(std::move(path))
    {
        // What stands behind the XML may be bytes that are none: the XML is read up to them.
        std::string head;
        const std::size_t appended = content.find("<AppendedData");
        if (appended != content.npos) {
            const std::size_t begin = content.find('_', content.find('>', appended));
            if (begin == content.npos)
                fail("the appended data do not start with '_'");
            const std::string_view tag = content.substr(appended, begin - appended);
            is_base64_ = tag.find("base64") != tag.npos;
            appended_ = content.substr(begin + 1);
            head = std::string(content.substr(0, appended)) + "</VTKFile>";
        }
        const std::string_view xml = head.empty() ? content : std::string_view(head);
        if (std::ranges::count(xml, '<') > most_tags)
            throw LimitExceeded(
                join(path_, ": more than ", most_tags, " tags of XML; polydata has a few dozen"));
        const pugi::xml_parse_result result = document_.load_buffer(xml.data(), xml.size());
        if (result.status == pugi::status_out_of_memory)
            throw std::bad_alloc();
        if (!result)
            fail(join("byte ", result.offset, ": ", result.description(),
                      "; is this a whole XML file of VTK?"));
        const pugi::xml_node file = document_.child("VTKFile");
        if (std::string_view(file.attribute("type").value()) != "PolyData")
            fail(join("the dataset is ", in_quotes(file.attribute("type").value()),
                      ", must be PolyData: extract the surface first"));
        const bool is_big = std::string_view(file.attribute("byte_order").value()) == "BigEndian";
        swap_ = is_big == (std::endian::native == std::endian::little);
        head_size_ = std::string_view(file.attribute("header_type").value()) == "UInt64" ? 8 : 4;
        compressor_ = file.attribute("compressor").value();
        pieces_ = file.child("PolyData");
    }

    [[noreturn]] void fail(std::string_view rule) const
    {
        throw InvalidInput(join(path_, ": ", rule));
    }

    [[nodiscard]] pugi::xml_node pieces() const { return pieces_; }

    [[nodiscard]] std::int64_t count(pugi::xml_node piece, const char* name) const
    {
        const pugi::xml_attribute attribute = piece.attribute(name);
        if (!attribute)
            return 0;
        const std::optional<std::int64_t> value = spelled_integer(attribute.value());
        if (!value || *value < 0 || *value > std::numeric_limits<int>::max())
            fail(join(name, " is ", in_quotes(attribute.value()), ", must be an integer in [0, ",
                      std::numeric_limits<int>::max(), "]"));
        return *value;
    }

    [[nodiscard]] ScalarType type(pugi::xml_node array) const
    {
        const std::optional<ScalarType> type = xml_vtk_type(array.attribute("type").value());
        if (!type)
            fail(join("an array of type ", in_quotes(array.attribute("type").value()),
                      " is not read"));
        return *type;
    }

    [[nodiscard]] std::vector<double> numbers(pugi::xml_node array, std::int64_t count) const
    {
        const ScalarType kind = type(array);
        return values<double>(
            array, count, [&](const char* bytes) { return number_at(bytes, kind, swap_); },
            [](std::string_view text) { return spelled_number(text); });
    }

    [[nodiscard]] std::vector<std::int64_t> integers(pugi::xml_node array, std::int64_t count) const
    {
        const ScalarType kind = type(array);
        if (!is_integer(kind))
            fail("indices must have an integer type");
        return values<std::int64_t>(
            array, count,
            [&](const char* bytes) {
                const std::optional<std::int64_t> value = integer_at(bytes, kind, swap_);
                if (!value)
                    fail(join("array ", in_quotes(array.attribute("Name").value()), " holds ",
                              unsigned_at(bytes, swap_),
                              ", which is beyond what can be counted, 2^63 - 1"));
                return *value;
            },
            [](std::string_view text) { return spelled_integer(text); });
    }

private:
    template <class Value, class FromBytes, class FromText>
    [[nodiscard]] std::vector<Value> values(pugi::xml_node array, std::int64_t count,
                                            const FromBytes& from_bytes,
                                            const FromText& from_text) const
    {
        const std::string name = in_quotes(array.attribute("Name").value());
        std::vector<Value> result;
        if (std::string_view(array.attribute("format").value()) == "ascii") {
            std::string_view text = array.child_value();
            const auto skip = [&] {
                text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
            };
            for (skip(); !text.empty() && std::ssize(result) < count; skip()) {
                const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
                const auto value = from_text(word);
                if (!value)
                    fail(join("array ", name, " holds ", in_quotes(word), ", ",
                              std::is_same_v<Value, double> ? "must be finite numbers"
                                                            : broken_rule_of_integer(word)));
                result.push_back(*value);
                text.remove_prefix(word.size());
            }
            if (std::ssize(result) < count || !text.empty())
                fail(join("array ", name, " must hold ", counted(count, "value"), ", holds ",
                          text.empty() ? "fewer" : "more"));
            return result;
        }
        const std::int64_t size = size_of(type(array));
        const std::string bytes = decoded(array, to_size(count * size));
        if (std::ssize(bytes) != count * size)
            fail(join("array ", name, " must hold ", counted(count, "value"), " of ",
                      counted(size, "byte"), ", holds ", counted(bytes.size(), "byte")));
        result.reserve(to_size(count));
        for (std::int64_t i = 0; i < count; ++i)
            result.push_back(from_bytes(bytes.data() + i * size));
        return result;
    }

    /// The bytes of an array that is not text; `expected` if the file is right.
    [[nodiscard]] std::string decoded(pugi::xml_node array, std::size_t expected) const
    {
        const std::string_view format = array.attribute("format").value();
        std::string_view source;
        bool is_base64 = true;
        if (format == "appended") {
            const std::int64_t offset = count(array, "offset");
            if (to_size(offset) > appended_.size())
                fail(join("an array lies at ", offset, ", behind the end of the file"));
            source = appended_.substr(to_size(offset));
            is_base64 = is_base64_;
        } else if (format == "binary") {
            source = array.child_value();
        } else {
            fail(join("the format of an array is ", in_quotes(format),
                      ", must be ascii, binary or appended"));
        }
        // At most `most` bytes from its start.
        const auto bytes = [&](std::size_t most) {
            return is_base64 ? decode_base64(source, most) : std::string(source.substr(0, most));
        };
        const auto word = [&](const std::string& from, std::size_t index) -> std::size_t {
            const auto found =
                integer_at(from.data() + index * head_size_,
                           head_size_ == 8 ? ScalarType::Uint64 : ScalarType::Uint32, swap_);
            const std::size_t value = found ? to_size(*found) : source.size() + 1;
            return value;
        };
        if (compressor_.empty()) {
            const std::string head = bytes(head_size_);
            if (head.size() < head_size_ || word(head, 0) != expected)
                fail(join("an array should be of ", counted(expected, "byte"),
                          ", the file says otherwise"));
            return bytes(head_size_ + expected).substr(head_size_);
        }
        if (compressor_ != "vtkZLibDataCompressor")
            fail(join("is compressed by ", in_quotes(compressor_),
                      "; write it with the compressor zlib, or none"));
        if (expected == 0)
            return {};
        // Number of blocks, size of each, of the last if that is smaller, and what they take compressed.
        const std::string start = bytes(3 * head_size_);
        if (start.size() < 3 * head_size_)
            fail("an array ends within its head");
        const std::size_t blocks = word(start, 0);
        const std::size_t block_size = word(start, 1);
        const std::size_t last = word(start, 2);
        if (blocks == 0 || blocks > source.size() / head_size_ || block_size == 0 ||
            block_size > expected + 65536 || last > block_size ||
            expected / 2000 > source.size()) // zlib packs at most 1 : 1032
            fail("the blocks of a compressed array do not fit its size");
        const std::size_t head_bytes = (3 + blocks) * head_size_;
        const std::string head = bytes(head_bytes);
        if (head.size() < head_bytes)
            fail("an array ends within its head");
        std::size_t packed = 0;
        for (std::size_t b = 0; b < blocks; ++b) {
            if (word(head, 3 + b) > source.size() - packed)
                fail("the blocks of a compressed array are longer than the file");
            packed += word(head, 3 + b);
        }
        const std::string all = bytes(head_bytes + packed);
        std::string result;
        result.reserve(expected);
        std::string block(block_size, '\0');
        std::size_t offset = head_bytes;
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::size_t size = word(head, 3 + b);
            uLongf length = block.size();
            if (offset + size > all.size() ||
                uncompress(reinterpret_cast<Bytef*>(block.data()), &length,
                           reinterpret_cast<const Bytef*>(all.data() + offset), size) != Z_OK ||
                result.size() + length > expected)
                fail("a compressed array is damaged");
            result.append(block.data(), length);
            offset += size;
        }
        return result;
    }

    std::string path_;
    pugi::xml_document document_;
    pugi::xml_node pieces_;
    std::string_view appended_;
    std::string compressor_;
    bool is_base64_ = false;
    bool swap_ = false;
    std::size_t head_size_ = 4;
};

/// A piece's polygons or strips.
VtkCells read_cells(const VtpReader& reader, pugi::xml_node cells, std::int64_t count)
{
    VtkCells result;
    if (count == 0)
        return result;
    const pugi::xml_node ends = cells.find_child_by_attribute("DataArray", "Name", "offsets");
    const pugi::xml_node corners =
        cells.find_child_by_attribute("DataArray", "Name", "connectivity");
    if (!ends || !corners)
        reader.fail("cells lack the array 'offsets' or 'connectivity'");
    result.ends = reader.integers(ends, count);
    const std::int64_t all = result.ends.back();
    if (all < 0 || all > 3 * MeshBuilder::face_limit)
        reader.fail(join("the last of the offsets is ", all));
    result.connectivity = reader.integers(corners, all);
    return result;
}

} // namespace

MeshFileContent parse_vtp(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options)
{
    const VtpReader reader(content, path.string());
    const MeshBuilder::Fail fail = [&](std::string_view rule) { reader.fail(rule); };
    MeshBuilder mesh(path, options, fail);
    bool is_single = false;
    for (const pugi::xml_node piece : reader.pieces().children("Piece")) {
        const std::int64_t first = mesh.vertex_count();
        const std::int64_t count = reader.count(piece, "NumberOfPoints");
        if (first + count > MeshBuilder::vertex_limit)
            mesh.reserve(first + count, 0); // says so
        if (count > 0) {
            const pugi::xml_node array = piece.child("Points").child("DataArray");
            if (reader.count(array, "NumberOfComponents") != 3)
                reader.fail("points must have three components");
            is_single = is_single || reader.type(array) == ScalarType::Float32;
            const std::vector<double> numbers = reader.numbers(array, 3 * count);
            for (std::size_t i = 0; i < numbers.size(); i += 3)
                mesh.add_vertex(numbers[i], numbers[i + 1], numbers[i + 2]);
        }
        add_cells(mesh,
                  read_cells(reader, piece.child("Polys"), reader.count(piece, "NumberOfPolys")),
                  first, false, fail);
        add_cells(mesh,
                  read_cells(reader, piece.child("Strips"), reader.count(piece, "NumberOfStrips")),
                  first, true, fail);
    }
    return {.meshes = {mesh.finish()}, .single_precision = is_single};
}

} // namespace shape::internal
