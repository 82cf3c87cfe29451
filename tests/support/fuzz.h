#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cairn::test {

/// Takes any bytes and must neither crash, hang nor touch memory that is not its own, as
/// LLVMFuzzerTestOneInput of libFuzzer has it. What it decodes it throws away.
using FuzzTarget = void (*)(std::span<const std::byte> input);

/// Calls the target with `count` inputs that are made from the seeds, and from the files of
/// tests/fuzz/corpus/NAME where there are any, by cutting, flipping, inserting, moving and overwriting bytes.
/// A run makes the inputs of the run before. Each input is an allocation of exactly its size, so that a
/// sanitizer sees every overrun.
///
/// In the program `cairn-fuzz` (scripts/fuzz), libFuzzer makes the inputs instead, guided by the code that
/// they reach, for as long as CAIRN_FUZZ_SECONDS says.
void run_fuzz(const std::string& name, FuzzTarget target, const std::vector<std::vector<std::byte>>& seeds,
              int count);

}  // namespace cairn::test
