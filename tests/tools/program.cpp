// SPDX-License-Identifier: MIT

#include "tests/tools/program.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "libshape/io/mesh_file.h"
#include "tests/support/meshes.h"

namespace shape::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* no_file = "(no file)"; ///< As the content of a directory.

std::string read_file(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void redirect(const fs::path& path, int descriptor)
{
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, descriptor);
    close(file);
}

/// Makes descriptor the writing end of a pipe without a reading end.
void redirect_to_closed_pipe(int descriptor)
{
    int ends[2];
    if (pipe(ends) != 0)
        _exit(127);
    close(ends[0]);
    dup2(ends[1], descriptor);
    close(ends[1]);
}

[[noreturn]] void become_the_program(const fs::path& folder, const Folder& streams,
                                     std::vector<std::string> arguments, const Launch& launch)
{
    if (launch.close_stdout)
        redirect_to_closed_pipe(STDOUT_FILENO);
    else
        redirect(streams / "out", STDOUT_FILENO);
    redirect(streams / "err", STDERR_FILENO);
    for (const std::string& assignment : launch.environment) {
        const std::size_t sign = assignment.find('=');
        setenv(assignment.substr(0, sign).c_str(), assignment.c_str() + sign + 1, 1);
    }
    if (launch.largest_file > 0) {
        const rlimit limit{launch.largest_file, launch.largest_file};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    if (launch.address_space > 0) {
        const rlimit limit{launch.address_space, launch.address_space};
        setrlimit(RLIMIT_AS, &limit);
    }
    if (launch.as_ordinary_user && geteuid() == 0)
        for (const int right : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH})
            if (prctl(PR_CAPBSET_DROP, right, 0, 0, 0) != 0) // that of what is executed
                _exit(127);
    if (chdir(folder.c_str()) != 0)
        _exit(127);
    if (!launch.input_file.empty()) {
        const int file = open(launch.input_file.c_str(), O_RDONLY);
        dup2(file, STDIN_FILENO);
        close(file);
    }
    std::string program = SHAPE_PROGRAM;
    std::vector<char*> argv{program.data()};
    for (std::string& argument : arguments)
        argv.push_back(argument.data());
    argv.push_back(nullptr);
    execv(program.c_str(), argv.data());
    _exit(127);
}

std::ptrdiff_t entry_count(const fs::path& folder)
{
    return std::distance(fs::directory_iterator(folder), {});
}

bool has_content(const fs::path& file)
{
    std::error_code missing;
    const std::uintmax_t size = fs::file_size(file, missing);
    return !missing && size > 0;
}

/// Whether a process has a handler of SIGINT.
bool catches_interrupts(pid_t process)
{
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string word; status >> word;)
        if (word == "SigCgt:" && status >> word)
            return (std::stoull(word, nullptr, 16) >> (SIGINT - 1U) & 1U) != 0;
    return false;
}

} // namespace

Outcome run_shape(const fs::path& folder, const std::vector<std::string>& arguments,
                  const Launch& launch)
{
    using namespace std::chrono;
    const Folder streams;
    const std::ptrdiff_t entries = entry_count(folder);
    const pid_t child = fork();
    if (child == 0)
        become_the_program(folder, streams, arguments, launch);
    int status = 0;
    bool interrupted = false;
    const auto start = steady_clock::now();
    while (waitpid(child, &status, WNOHANG) == 0) {
        const bool is_there =
            !launch.interrupt_at_file.empty() && fs::exists(folder / launch.interrupt_at_file);
        const bool has_changed = launch.interrupt_at_change && entry_count(folder) != entries;
        const bool has_spoken = launch.interrupt_at_message && has_content(streams / "err");
        const bool is_caught = launch.interrupt_when_caught && catches_interrupts(child);
        if (!interrupted && (is_there || has_changed || has_spoken || is_caught)) {
            kill(child, SIGINT);
            interrupted = true;
        }
        if (steady_clock::now() - start > minutes(1))
            kill(child, SIGKILL);
        std::this_thread::sleep_for(milliseconds(1));
    }
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            read_file(streams / "out"), read_file(streams / "err")};
}

void Folder::write(const std::string& name, std::string_view content) const
{
    fs::create_directories((path() / name).parent_path());
    write_bytes(path() / name, content);
}

std::string Folder::read(const std::string& name) const
{
    return read_file(path() / name);
}

bool Folder::has(const std::string& name) const
{
    return fs::exists(path() / name);
}

std::map<std::string, std::string> Folder::content() const
{
    std::map<std::string, std::string> content;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path()))
        content[fs::relative(entry.path(), path()).string()] =
            entry.is_regular_file() ? read_file(entry.path()) : no_file;
    return content;
}

MadeOnce::MadeOnce(const std::function<void(const Folder&)>& make)
{
    const Folder folder;
    make(folder);
    content_ = folder.content();
}

void MadeOnce::copy_into(const Folder& folder) const
{
    for (const auto& [name, content] : content_)
        if (content == no_file)
            fs::create_directories(folder / name);
        else
            folder.write(name, content);
}

void run_or_throw(const Folder& folder, const Arguments& arguments)
{
    const Outcome outcome = run_shape(folder.path(), arguments);
    if (outcome.exit_code != 0)
        throw std::runtime_error(outcome.err);
}

void write_bumpy_spheres(const Folder& folder)
{
    unsigned seed = 1;
    for (const char* name : {"a.ply", "b.ply", "c.ply"}) {
        const TestMesh mesh = bumpy_sphere(1, 0.2, seed++);
        write_mesh(folder / name, mesh.points, mesh.topology.faces(), MeshFormat::Ply);
    }
    folder.write("labels.csv", "mesh,subject,mood\na,x,calm\nb,x,glad\nc,y,calm\n");
}

int line_count(std::string_view text)
{
    const auto ends = std::count(text.begin(), text.end(), '\n');
    return static_cast<int>(ends) + (text.empty() || text.back() == '\n' ? 0 : 1);
}

std::vector<std::string> files_in(const fs::path& directory)
{
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace shape::test
