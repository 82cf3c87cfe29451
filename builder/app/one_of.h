#pragma once

#include <map>
#include <string>

#include <CLI/CLI.hpp>

namespace cairn {

/// Accepts the words of the map, in any case. The help lists the words; CLI11's own description lists the
/// enumerators' bytes as well.
template <class Value>
CLI::Validator one_of(const std::map<std::string, Value>& words) {
  std::string list;
  for (const auto& word : words) list += (list.empty() ? "" : ",") + word.first;
  return CLI::CheckedTransformer(words, CLI::ignore_case).description("{" + list + "}");
}

}  // namespace cairn
