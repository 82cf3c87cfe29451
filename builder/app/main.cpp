#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "builder/app/external_verb.h"
#include "builder/app/verbs.h"

namespace {

constexpr int kUsage = 2;

/// The arguments with -.5 written as -0.5, since the parser takes a minus and a point for an option.
std::vector<std::string> with_leading_zeros(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto starts_fraction = [](const std::string& text, std::size_t at) {
    return text.compare(at, 2, "-.") == 0 && at + 2 < text.size() &&
           std::isdigit(static_cast<unsigned char>(text[at + 2])) != 0;
  };
  for (std::string& argument : arguments)
    if (starts_fraction(argument, 0)) argument.insert(1, "0");
  return arguments;
}

int run(int argc, char** argv) {
  CLI::App app("cairn: terrain packs from elevation rasters", "cairn");
  app.set_version_flag("--version", "cairn " CAIRN_VERSION);
  app.require_subcommand(1);
  app.failure_message(
      [](const CLI::App*, const CLI::Error& error) { return fmt::format("cairn: {}\n", error.what()); });
  int exit_code = 0;
  cairn::add_bake(app, exit_code);
  cairn::add_plan(app, exit_code);
  cairn::add_merge(app, exit_code);
  cairn::add_update(app, exit_code);
  cairn::add_info(app, exit_code);
  cairn::add_verify(app, exit_code);
  cairn::add_diff(app, exit_code);
  cairn::add_sample(app, exit_code);
  cairn::add_extract(app, exit_code);
  cairn::add_export(app, exit_code);
  cairn::add_hillshade(app, exit_code);
  cairn::add_serve(app, exit_code);
  cairn::add_inspect(app, exit_code);

  for (const cairn::ExternalVerb& verb : cairn::kExternalVerbs) app.add_subcommand(verb.name, verb.summary);
  app.footer("A verb that is not listed is looked for as cairn-VERB beside this program.");

  if (argc < 2) {
    fmt::print("{}", app.help());
    return 0;
  }
  const auto is_named = [&](const CLI::App* verb) { return verb->check_name(argv[1]); };
  const bool is_external =
      std::any_of(cairn::kExternalVerbs.begin(), cairn::kExternalVerbs.end(),
                  [&](const cairn::ExternalVerb& verb) { return std::strcmp(verb.name, argv[1]) == 0; });
  if (is_external || (argv[1][0] != '-' && app.get_subcommands(is_named).empty())) {
    const auto sibling = cairn::find_external_verb(argv[1]);
    if (sibling) cairn::become(*sibling, argv + 1);
    if (is_external) {
      fmt::print(stderr, "cairn: {0}: expected the program cairn-{0} beside cairn, found none\n", argv[1]);
      return kUsage;
    }
    fmt::print(stderr, "cairn: verb: expected one of `cairn --help` or a program cairn-{0}, found {0}\n",
               argv[1]);
    return kUsage;
  }
  try {
    auto arguments = with_leading_zeros(argc, argv);
    std::reverse(arguments.begin(), arguments.end());  // as the parser takes them
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // out of memory, at worst
    fmt::print(stderr, "cairn: {}\n", error.what());
    return 1;
  }
}
