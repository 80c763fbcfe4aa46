// SPDX-License-Identifier: MIT

#include "tools/program/session.h"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "tools/program/progress_listener.h"
#include "tools/program/report.h"

namespace shape::tools {
using namespace internal;
namespace {

bool bar_is_drawn = false;

/// Printed when the run has ended, so that an error finds its place beside them.
Json waiting_figures = Json::object();

thread_local Progress listener; ///< Empty: progress goes to the terminal.

void clear_bar()
{
    if (bar_is_drawn)
        std::fputs("\r\033[K", stderr);
    bar_is_drawn = false;
}

/// The text in one line that can be read: without control characters, and without the rest of what goes on for
/// pages, as numbers of a million digits in a damaged file do.
std::string one_line(std::string text)
{
    constexpr std::size_t most = 4000;
    if (text.size() > most) {
        std::size_t end = most;
        while ((static_cast<unsigned char>(text[end]) & 0xC0U) ==
               0x80U) // within a character of UTF-8
            --end;
        const std::size_t rest = text.size() - end;
        text.resize(end);
        text += " ... (" + std::to_string(rest) + " bytes more)";
    }
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = ' ';
    return text;
}

/// "40 s", "12 min" or "3 h 05 min".
std::string print_duration(double seconds)
{
    char text[32];
    const auto minutes = std::lround(seconds / 60.0);
    if (seconds < 99.5)
        std::snprintf(text, sizeof text, "%.0f s", seconds);
    else if (minutes < 100)
        std::snprintf(text, sizeof text, "%ld min", minutes);
    else
        std::snprintf(text, sizeof text, "%ld h %02ld min", minutes / 60, minutes % 60);
    return text;
}

/// Draws the state of one stage of the work, at most ten times a second.
class Bar
{
public:
    void update(std::string_view stage, std::size_t done, std::size_t total)
    {
        const Mark now{Clock::now(), done};
        if (stage != stage_ || done < last_.done) {
            stage_ = stage;
            last_ = before_ = now;
        }
        if (now.time - last_.time > std::chrono::seconds(10))
            before_ = std::exchange(last_, now);
        if (done >= total)
            return clear_bar();
        if (now.time - drawn_ < std::chrono::milliseconds(100))
            return;
        drawn_ = now.time;
        draw(now, total);
    }

private:
    using Clock = std::chrono::steady_clock;
    struct Mark
    {
        Clock::time_point time;
        std::size_t done = 0;
    };

    /// The time left follows the speed of the last ten to twenty seconds: a resumed run takes what is
    /// finished much faster than it makes the rest.
    void draw(const Mark& now, std::size_t total) const
    {
        const std::size_t width = 30;
        const std::size_t filled = width * now.done / total;
        std::ostringstream line;
        line.precision(3);
        line << "\r\033[K" << stage_ << " [" << std::string(filled, '#')
             << std::string(width - filled, '.') << "] " << now.done << "/" << total;
        if (now.done > before_.done) {
            const double seconds = std::chrono::duration<double>(now.time - before_.time).count();
            if (stage_.ends_with("kB")) // read or written: how fast
                line << ", " << static_cast<double>(now.done - before_.done) / 1000.0 / seconds
                     << " MB/s";
            line << ", "
                 << print_duration(seconds / static_cast<double>(now.done - before_.done) *
                                   static_cast<double>(total - now.done))
                 << " left";
        }
        std::fputs(line.str().c_str(), stderr);
        bar_is_drawn = true;
    }

    std::string stage_;
    Mark last_;   ///< Ten seconds ago at most,
    Mark before_; ///< and ten before that.
    Clock::time_point drawn_;
};

} // namespace

void Session::message(const std::string& text) const
{
    if (quiet || json)
        return;
    clear_bar();
    std::fprintf(stderr, "%s%s", readable(text).c_str(), text.ends_with('\n') ? "" : "\n");
}

void Session::warn(const std::string& text) const
{
    if (quiet)
        return;
    clear_bar();
    std::fprintf(stderr, "shape: warning: %s\n", one_line(readable(text)).c_str());
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
    if (json)
        waiting_figures.update(figures);
}

void print_report(const Session& session, const Json& error)
{
    if (!session.json)
        return;
    Json object{{"command", session.command.empty() ? Json() : Json(session.command)},
                {"schema", json_schema}};
    object.update(waiting_figures);
    if (!error.is_null())
        object["error"] = error;
    session.print(session.readable(object.dump(2, ' ', false, Json::error_handler_t::replace)) +
                  "\n");
}

ProgressListener::ProgressListener(Progress told)
{
    listener = std::move(told);
}

ProgressListener::~ProgressListener()
{
    listener = nullptr;
}

Progress Session::progress() const
{
    if (listener)
        return listener;
    if (quiet || isatty(STDERR_FILENO) == 0)
        return [](std::string_view, std::size_t, std::size_t) { throw_if_stop_requested(); };
    return [bar = Bar()](std::string_view stage, std::size_t done, std::size_t total) mutable {
        throw_if_stop_requested();
        bar.update(stage, done, total);
    };
}

void report_error(const std::string& text)
{
    clear_bar();
    std::fprintf(stderr, "shape: error: %s\n", one_line(text).c_str());
}

} // namespace shape::tools
