// SPDX-License-Identifier: MIT

#pragma once

#include <map>
#include <string>
#include <vector>

namespace shape::test {

/// An element of an XML document.
struct XmlElement
{
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string text; ///< Directly inside, entities replaced.
};

/// The elements in document order: enough of XML for pictures of libshape.
/// @throws std::runtime_error if the document is not well-formed.
[[nodiscard]] std::vector<XmlElement> parse_xml(const std::string& document);

/// Those with a name.
[[nodiscard]] std::vector<XmlElement> named(const std::vector<XmlElement>& elements,
                                            const std::string& name);

} // namespace shape::test
