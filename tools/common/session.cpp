// SPDX-License-Identifier: MIT

#include "tools/common/session.h"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "tools/common/interrupt.h"

namespace shape::tools {
namespace {

bool bar_is_drawn = false;

void clear_bar()
{
    if (bar_is_drawn)
        std::fputs("\r\033[K", stderr);
    bar_is_drawn = false;
}

std::string one_line(std::string text)
{
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = ' ';
    return text;
}

/// Draws the state of one stage of the work, at most ten times a second.
class Bar
{
public:
    void update(std::string_view stage, std::size_t done, std::size_t total)
    {
        const Clock::time_point now = Clock::now();
        if (stage != stage_ || done < done_) {
            stage_ = stage;
            start_ = now;
            start_done_ = done;
        }
        done_ = done;
        if (done >= total)
            return clear_bar();
        if (now - drawn_ < std::chrono::milliseconds(100))
            return;
        drawn_ = now;
        draw(total, std::chrono::duration<double>(now - start_).count());
    }

private:
    using Clock = std::chrono::steady_clock;

    void draw(std::size_t total, double seconds) const
    {
        const std::size_t width = 30;
        const std::size_t filled = width * done_ / total;
        std::ostringstream line;
        line << "\r\033[K" << stage_ << " [" << std::string(filled, '#')
             << std::string(width - filled, '.') << "] " << done_ << "/" << total;
        if (done_ > start_done_) {
            const double left = seconds / static_cast<double>(done_ - start_done_) *
                                static_cast<double>(total - done_);
            line << ", " << std::fixed << std::setprecision(0) << left << " s left";
        }
        std::fputs(line.str().c_str(), stderr);
        bar_is_drawn = true;
    }

    std::string stage_;
    std::size_t done_ = 0;
    std::size_t start_done_ = 0;
    Clock::time_point start_;
    Clock::time_point drawn_;
};

} // namespace

void Session::message(const std::string& text) const
{
    if (quiet || json)
        return;
    clear_bar();
    std::fprintf(stderr, "%s%s", text.c_str(), text.ends_with('\n') ? "" : "\n");
}

void Session::warn(const std::string& text) const
{
    if (quiet)
        return;
    clear_bar();
    std::fprintf(stderr, "shape: warning: %s\n", one_line(text).c_str());
}

void Session::print(const std::string& text) const
{
    clear_bar();
    errno = 0;
    const bool written =
        std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written && errno != EPIPE)
        throw FileError(join("standard output: ", std::strerror(errno)));
}

void Session::print_figures(const Json& figures) const
{
    if (!json)
        return;
    Json object{{"command", command}};
    object.update(figures);
    print(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

Progress Session::progress() const
{
    if (quiet || isatty(STDERR_FILENO) == 0)
        return [](std::string_view, std::size_t, std::size_t) { throw_if_interrupted(); };
    return [bar = Bar()](std::string_view stage, std::size_t done, std::size_t total) mutable {
        throw_if_interrupted();
        bar.update(stage, done, total);
    };
}

void report_error(const std::string& text)
{
    clear_bar();
    std::fprintf(stderr, "shape: error: %s\n", one_line(text).c_str());
}

} // namespace shape::tools
