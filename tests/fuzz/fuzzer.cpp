// SPDX-License-Identifier: MIT
//
// libFuzzer's side: SHAPE_FUZZ_TARGET names the target; tests/fuzz/run starts it.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
    static const shape::fuzz::Target& target = []() -> const shape::fuzz::Target& {
        const char* name = std::getenv("SHAPE_FUZZ_TARGET");
        return shape::fuzz::find_target(name == nullptr ? "" : name);
    }();
    target.run({reinterpret_cast<const char*>(bytes), size});
    return 0;
}
