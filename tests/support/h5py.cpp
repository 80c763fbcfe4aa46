// SPDX-License-Identifier: MIT

#include "tests/support/h5py.h"

#include <cstdlib>
#include <stdexcept>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape::test {
namespace {

/// What a Python program prints, errors too.
std::string run_python(const std::filesystem::path& directory, const std::string& program)
{
    const std::filesystem::path script = directory / "script.py";
    const std::filesystem::path output = directory / "script.txt";
    write_bytes(script, program);
    (void)!std::system(
        (python_with_h5py() + " '" + script.string() + "' >'" + output.string() + "' 2>&1")
            .c_str());
    const std::string printed = read_bytes(output);
    std::filesystem::remove(script);
    std::filesystem::remove(output);
    return printed;
}

const std::string imports = "import h5py, numpy as np, os, shutil\n";

} // namespace

std::string python_with_h5py()
{
    static const std::string found = [] {
        for (const std::string python : {"python3", "/usr/bin/python3"})
            if (std::system((python + " -c 'import h5py' 2>/dev/null").c_str()) == 0)
                return python;
        return std::string();
    }();
    return found;
}

std::string run_h5py(const std::filesystem::path& file, const std::string& mode,
                     const std::string& statements)
{
    return run_python(file.parent_path(), imports + "f = h5py.File(r'" + file.string() + "', '" +
                                              mode + "')\n" + statements + "\nf.close()\n");
}

std::vector<std::filesystem::path> edit_with_h5py(const std::filesystem::path& file,
                                                  const std::vector<std::string>& edits)
{
    std::vector<std::filesystem::path> copies;
    std::string program = imports;
    for (const std::string& edit : edits) {
        copies.push_back(file.parent_path() / ("edit" + std::to_string(copies.size()) + ".h5"));
        program += "shutil.copy(r'" + file.string() + "', r'" + copies.back().string() +
                   "')\nf = h5py.File(r'" + copies.back().string() + "', 'r+')\n" + edit +
                   "\nf.close()\n";
    }
    const std::string printed = run_python(file.parent_path(), program);
    if (!printed.empty())
        throw std::runtime_error(printed);
    return copies;
}

void expect_refused(const std::filesystem::path& file, const std::vector<BadEdit>& edits,
                    const std::function<void(const std::filesystem::path&)>& read)
{
    std::vector<std::string> statements;
    for (const BadEdit& bad : edits)
        statements.push_back(bad.edit);
    const std::vector<std::filesystem::path> copies = edit_with_h5py(file, statements);
    for (std::size_t i = 0; i < edits.size(); ++i) {
        SCOPED_TRACE(edits[i].edit);
        const std::string message = message_of<InvalidInput>([&] { read(copies[i]); });
        EXPECT_TRUE(message.starts_with(copies[i].string() + ": " + edits[i].place + ": "))
            << message;
        EXPECT_NE(message.find(edits[i].rule), std::string::npos) << message;
    }
}

} // namespace shape::test
