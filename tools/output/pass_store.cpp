// SPDX-License-Identifier: MIT

#include "tools/output/pass_store.h"

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "tools/output/frame_store.h"

namespace shape::tools {
using namespace internal;
namespace {

// The file:  8 letters, the identity, numbers, arrays (rows, columns, values), a hash of all of it.
// Texts and numbers have their count before them; everything in the machine's order.

constexpr std::string_view letters = "HSPass01";

/// Writes bytes and hashes them.
class Writer
{
public:
    explicit Writer(int descriptor) : descriptor_(descriptor) {}

    void put(const void* bytes, std::size_t size)
    {
        hash_ = hash_text(bytes, size, hash_);
        write_all(bytes, size);
    }
    void put(std::uint64_t number) { put(&number, sizeof number); }
    void finish() { write_all(hash_.data(), hash_.size()); }

private:
    void write_all(const void* bytes, std::size_t size) const
    {
        const auto* from = static_cast<const char*>(bytes);
        while (size > 0) {
            const ssize_t done = ::write(descriptor_, from, size);
            if (done < 0 && errno == EINTR)
                continue;
            if (done < 0)
                throw FileError(join("cannot keep the state of the run: ", std::strerror(errno)));
            from += done;
            size -= to_size(done);
        }
    }

    int descriptor_;
    std::string hash_;
};

class Reader
{
public:
    explicit Reader(const std::filesystem::path& path)
        : path_(path), in_(path, std::ios::binary), left_(std::filesystem::file_size(path))
    {
    }

    void get(void* bytes, std::uint64_t size)
    {
        take(bytes, size);
        hash_ = hash_text(bytes, size, hash_);
    }
    std::uint64_t number()
    {
        std::uint64_t number = 0;
        get(&number, sizeof number);
        return number;
    }
    /// A count of things of `size` bytes each, which must be there.
    std::uint64_t count(std::uint64_t size)
    {
        const std::uint64_t count = number();
        if (count > left_ / size)
            fail();
        return count;
    }
    void finish()
    {
        std::string hash(hash_.size(), '\0');
        take(hash.data(), hash.size());
        if (hash != hash_ || left_ != 0)
            fail();
    }
    [[noreturn]] void fail() const
    {
        throw InvalidInput(join(path_.string(),
                                ": is not the state of an interrupted run, or is damaged; "
                                "remove it"));
    }

private:
    void take(void* bytes, std::uint64_t size)
    {
        if (size > left_ ||
            !in_.read(static_cast<char*>(bytes), static_cast<std::streamsize>(size)))
            fail();
        left_ -= size;
    }

    std::filesystem::path path_;
    std::ifstream in_;
    std::uint64_t left_;
    std::string hash_;
};

std::pair<std::string, PassState> read_state(const std::filesystem::path& path)
{
    Reader reader(path);
    std::string found(letters.size(), '\0');
    reader.get(found.data(), found.size());
    if (found != letters)
        reader.fail();
    std::string identity(reader.count(1), '\0');
    reader.get(identity.data(), identity.size());
    PassState state;
    state.numbers.resize(reader.count(sizeof(std::int64_t)));
    reader.get(state.numbers.data(), state.numbers.size() * sizeof(std::int64_t));
    for (std::uint64_t arrays = reader.count(2 * sizeof(std::uint64_t)); arrays > 0; --arrays) {
        const std::uint64_t rows = reader.number();
        const std::uint64_t values = reader.count(sizeof(double));
        if (rows == 0 ? values != 0 : values % rows != 0)
            reader.fail();
        RowMatrix& array =
            state.arrays.emplace_back(static_cast<Eigen::Index>(rows),
                                      rows == 0 ? 0 : static_cast<Eigen::Index>(values / rows));
        reader.get(array.data(), values * sizeof(double));
    }
    reader.finish();
    return {std::move(identity), std::move(state)};
}

} // namespace

std::filesystem::path scratch_folder(const std::filesystem::path& output)
{
    return output.has_parent_path() ? output.parent_path() : ".";
}

namespace {

/// The names of what two identities do not share.
std::string differences(const Json& found, const Json& wanted)
{
    std::string names;
    for (const auto& [name, value] : wanted.items())
        if (!found.contains(name) || found.at(name) != value)
            names += (names.empty() ? "" : ", ") + name;
    return names;
}

} // namespace

PassStore::PassStore(const Session& session, const std::filesystem::path& output,
                     const Json& identity, bool resume, double seconds)
    : session_(session),
      file_(output.string() + ".unfinished"),
      identity_(identity.dump()),
      seconds_(seconds)
{
    if (!std::filesystem::exists(file_))
        return;
    if (!resume && !session.force)
        throw FileError(join(file_.string(),
                             ": an interrupted run has left it; --resume goes on "
                             "from there, --force starts anew"));
    if (!resume)
        return;
    auto [found, state] = read_state(file_);
    if (found != identity_)
        throw InvalidInput(join(file_.string(), ": the interrupted run was another: ",
                                differences(Json::parse(found), identity),
                                " had other values; give those, or without --resume --force, which "
                                "discards it"));
    state_ = std::move(state);
}

void PassStore::save(const PassState& state)
{
    using Clock = std::chrono::steady_clock;
    if (std::chrono::duration<double>(Clock::now() - last_).count() < seconds_)
        return;
    last_ = Clock::now();
    try {
        write(state);
    } catch (const FileError& error) { // the run needs it only if it is killed
        if (!std::exchange(has_warned_, true))
            session_.warn(join(file_.string(), ": ", error.what(),
                               "; the run goes on, but if it is killed it cannot go on from here"));
    }
}

void PassStore::write(const PassState& state) const
{
    write_file_atomically(file_, [&](int descriptor) {
        Writer writer(descriptor);
        writer.put(letters.data(), letters.size());
        writer.put(identity_.size());
        writer.put(identity_.data(), identity_.size());
        writer.put(state.numbers.size());
        writer.put(state.numbers.data(), state.numbers.size() * sizeof(std::int64_t));
        writer.put(state.arrays.size());
        for (const RowMatrix& array : state.arrays) {
            writer.put(static_cast<std::uint64_t>(array.rows()));
            writer.put(static_cast<std::uint64_t>(array.size()));
            writer.put(array.data(), to_size(array.size()) * sizeof(double));
        }
        writer.finish();
    });
}

std::string PassStore::on_interrupt() const
{
    if (std::error_code ignored; !std::filesystem::exists(file_, ignored))
        return join("interrupted; nothing was kept yet (--save-every ", seconds_, " s)");
    return join("interrupted; ", file_.string(),
                " has the passes before, the same command with --resume goes on from there");
}

void PassStore::finish()
{
    std::error_code ignored; // a file that stays harms nobody
    std::filesystem::remove(file_, ignored);
}

} // namespace shape::tools
