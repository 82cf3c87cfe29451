#pragma once

namespace cairn {

/// Loads a module of readers (NAME.so beside the library or the program that cairn is part of, or in ../lib/cairn of the program) for good, and returns its
/// entry; null where there is no such module or it cannot be loaded.
void* load_reader_plugin(const char* name, const char* entry);

}  // namespace cairn
