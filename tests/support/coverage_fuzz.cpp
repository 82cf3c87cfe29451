// run_fuzz() of the program cairn-fuzz: libFuzzer makes the inputs.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <catch2/catch.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/fuzz.h"
#include "tests/support/test_pack.h"

// libFuzzer's own entry, in the part of it that has no main().
extern "C" int LLVMFuzzerRunDriver(int* argc, char*** argv,
                                   int (*target)(const std::uint8_t* data, std::size_t size));

namespace cairn::test {
namespace {

FuzzTarget under_test = nullptr;  // libFuzzer calls a plain function

int run_one(const std::uint8_t* data, std::size_t size) {
  under_test(std::as_bytes(std::span(data, size)));
  return 0;
}

std::string required_setting(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr) FAIL("expected " << name << " to be set, as scripts/fuzz does");
  return value;
}

/// Ends the process.
[[noreturn]] void fuzz(const std::string& corpus, const std::string& seconds) {
  std::vector<std::string> words{
      "cairn-fuzz",         corpus,        "-max_total_time=" + seconds,      "-print_final_stats=1",
      "-rss_limit_mb=4096", "-timeout=60", "-artifact_prefix=" + corpus + "-"};
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(words.size());
  char** arguments = pointers.data();
  std::_Exit(LLVMFuzzerRunDriver(&count, &arguments, run_one));
}

}  // namespace

void run_fuzz(const std::string& name, FuzzTarget target, const std::vector<std::vector<std::byte>>& seeds,
              int) {
  const std::string only = required_setting("CAIRN_FUZZ_TARGETS");  // space NAME space ...; or all
  if (only != "all" && only.find(' ' + name + ' ') == std::string::npos) return;
  const std::filesystem::path corpus = std::filesystem::path(required_setting("CAIRN_FUZZ_CORPORA")) / name;
  const std::string seconds = required_setting("CAIRN_FUZZ_SECONDS");
  std::filesystem::create_directories(corpus);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    write_bytes(corpus / ("seed-" + std::to_string(i)), seeds[i]);

  under_test = target;
  const pid_t child = ::fork();
  if (child == 0) fuzz(corpus.string(), seconds);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  INFO("target " << name << "; libFuzzer's input that fails is beside " << corpus);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
}

}  // namespace cairn::test
