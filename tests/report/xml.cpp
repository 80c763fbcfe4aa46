// SPDX-License-Identifier: MIT

#include "tests/report/xml.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace shape::test {
namespace {

std::string unescaped(std::string text)
{
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '<')
            throw std::runtime_error("bare '<' in " + text);
        if (text[i] != '&') {
            result += text[i];
            continue;
        }
        static const std::map<std::string, char> entities{
            {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&#39;", '\''}};
        const std::string entity = text.substr(i, text.find(';', i) - i + 1);
        if (!entities.contains(entity))
            throw std::runtime_error("bad entity in " + text);
        result += entities.at(entity);
        i += entity.size() - 1;
    }
    return result;
}

class Parser
{
public:
    explicit Parser(const std::string& document) : text_(document) {}

    std::vector<XmlElement> run()
    {
        element();
        skip_space();
        expect(position_ == text_.size(), "something after the root element");
        return std::move(elements_);
    }

private:
    void expect(bool condition, const std::string& what) const
    {
        if (!condition)
            throw std::runtime_error(what + " at byte " + std::to_string(position_));
    }
    [[nodiscard]] bool at(const std::string& token) const
    {
        return text_.compare(position_, token.size(), token) == 0;
    }
    void take(const std::string& token)
    {
        expect(at(token), "expected " + token);
        position_ += token.size();
    }
    void skip_space()
    {
        while (position_ < text_.size() &&
               std::isspace(static_cast<unsigned char>(text_[position_])))
            ++position_;
    }
    std::string name()
    {
        const std::size_t start = position_;
        while (position_ < text_.size() &&
               (std::isalnum(static_cast<unsigned char>(text_[position_])) ||
                text_[position_] == '-' || text_[position_] == ':'))
            ++position_;
        expect(position_ > start, "no name");
        return text_.substr(start, position_ - start);
    }
    std::string until(char end)
    {
        const std::size_t stop = text_.find(end, position_);
        expect(stop != std::string::npos, std::string("no ") + end);
        std::string piece = text_.substr(position_, stop - position_);
        position_ = stop;
        return unescaped(piece);
    }
    void element()
    {
        take("<");
        const std::size_t index = elements_.size();
        elements_.push_back({name(), {}, {}});
        const std::string own_name = elements_[index].name;
        for (skip_space(); !at(">") && !at("/>"); skip_space()) {
            const std::string attribute = name();
            take("=\"");
            expect(elements_[index].attributes.emplace(attribute, until('"')).second,
                   "attribute twice");
            take("\"");
        }
        if (at("/>"))
            return take("/>");
        take(">");
        while (!at("</")) {
            if (at("<"))
                element();
            else
                elements_[index].text += until('<');
        }
        take("</" + own_name + ">");
    }

    const std::string& text_;
    std::size_t position_ = 0;
    std::vector<XmlElement> elements_;
};

} // namespace

std::vector<XmlElement> parse_xml(const std::string& document)
{
    return Parser(document).run();
}

std::vector<XmlElement> named(const std::vector<XmlElement>& elements, const std::string& name)
{
    std::vector<XmlElement> found;
    std::copy_if(elements.begin(), elements.end(), std::back_inserter(found),
                 [&](const XmlElement& element) { return element.name == name; });
    return found;
}

} // namespace shape::test
