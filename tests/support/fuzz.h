#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn::test {

/// Takes any bytes and must neither crash, hang nor touch memory that is not its own, as
/// LLVMFuzzerTestOneInput of libFuzzer has it. What it decodes it throws away.
using FuzzTarget = void (*)(std::span<const std::byte> input);

/// Calls the target with `count` inputs that are made from the seeds by cutting, flipping, inserting, moving
/// and overwriting bytes, the same ones each time. Each input is an allocation of exactly its size, so that a
/// sanitizer sees every overrun.
void run_fuzz(FuzzTarget target, const std::vector<std::vector<std::byte>>& seeds, int count);

}  // namespace cairn::test
