// SPDX-License-Identifier: MIT

#include <bit>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/mesh_formats.h"

namespace shape::internal {
namespace {

/// The arrays of a file: described in the XML, with their numbers there or behind it.
class VtpArrays
{
public:
    explicit VtpArrays(bool ascii) : ascii_(ascii) {}

    template <class Value>
    void add(std::string_view name, std::string_view type, int components,
             const std::vector<Value>& values)
    {
        xml += join("<DataArray type=\"", type, "\" Name=\"", name, "\" NumberOfComponents=\"",
                    components, "\" format=\"", ascii_ ? "ascii" : "appended", "\"");
        if (!ascii_) {
            xml += join(" offset=\"", appended.size(), "\"/>\n");
            const std::uint64_t size = values.size() * sizeof(Value);
            appended.append(reinterpret_cast<const char*>(&size), sizeof size);
            appended.append(reinterpret_cast<const char*>(values.data()), to_size(size));
            return;
        }
        xml += ">\n";
        for (std::size_t i = 0; i < values.size(); ++i) {
            if constexpr (sizeof(Value) == 1)
                append_number(xml, int{values[i]});
            else if constexpr (std::is_same_v<Value, std::int64_t>)
                append_number(xml, static_cast<int>(values[i]));
            else
                append_number(xml, values[i]);
            xml += (i + 1) % to_size(components) == 0 ? '\n' : ' ';
        }
        xml += "</DataArray>\n";
    }

    /// Coordinates or scalars, in the precision that is asked for.
    void add_reals(std::string_view name, int components, const std::vector<double>& values,
                   bool single_precision)
    {
        if (single_precision)
            add(name, "Float32", components, std::vector<float>(values.begin(), values.end()));
        else
            add(name, "Float64", components, values);
    }

    std::string xml;
    std::string appended;

private:
    bool ascii_;
};

} // namespace

std::string print_vtp(const Points& points, const Faces& faces, const MeshWriteOptions& options)
{
    check_colour_names(options, {"colours"});
    VtpArrays arrays(options.ascii);
    arrays.xml = join(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"",
        std::endian::native == std::endian::little ? "Little" : "Big",
        "Endian\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"", points.rows(),
        "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"",
        faces.rows(), "\">\n<PointData");
    if (!options.scalars.empty())
        arrays.xml += join(" Scalars=\"", options.scalars.front().name, "\"");
    arrays.xml += ">\n";
    for (const VertexScalar& scalar : options.scalars)
        arrays.add_reals(scalar.name, 1, {scalar.values.begin(), scalar.values.end()},
                         options.single_precision);
    if (options.colours.rows() > 0)
        arrays.add("colours", "UInt8", 3,
                   std::vector<std::uint8_t>(options.colours.data(),
                                             options.colours.data() + options.colours.size()));
    arrays.xml += "</PointData>\n<Points>\n";
    arrays.add_reals("Points", 3, {points.data(), points.data() + points.size()},
                     options.single_precision);
    arrays.xml += "</Points>\n<Polys>\n";
    arrays.add("connectivity", "Int64", 1,
               std::vector<std::int64_t>(faces.data(), faces.data() + faces.size()));
    std::vector<std::int64_t> ends(to_size(faces.rows()));
    for (std::size_t f = 0; f < ends.size(); ++f)
        ends[f] = 3 * static_cast<std::int64_t>(f + 1);
    arrays.add("offsets", "Int64", 1, ends);
    arrays.xml += "</Polys>\n</Piece>\n</PolyData>\n";
    if (!options.ascii)
        arrays.xml +=
            "<AppendedData encoding=\"raw\">\n_" + arrays.appended + "\n</AppendedData>\n";
    return arrays.xml + "</VTKFile>\n";
}

} // namespace shape::internal
