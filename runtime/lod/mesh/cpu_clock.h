#pragma once

namespace cairn {

/// CPU seconds that the calling thread has used since some fixed moment.
double thread_cpu_s();

}  // namespace cairn
