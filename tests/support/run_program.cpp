#include "tests/support/run_program.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <thread>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

void redirect(int descriptor, const std::filesystem::path& path, int flags) {
  const int file = ::open(path.c_str(), flags, 0666);
  if (file < 0 || ::dup2(file, descriptor) < 0) ::_exit(126);
}

// Its stdin, stdout and stderr are files of that folder.
pid_t start_words(std::vector<std::string> words, const std::filesystem::path& folder,
                  std::size_t most_file_bytes) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    redirect(0, folder / "in", O_RDONLY);
    redirect(1, folder / "out", O_WRONLY | O_CREAT);
    redirect(2, folder / "err", O_WRONLY | O_CREAT);
    if (most_file_bytes != RLIM_INFINITY) {
      const rlimit limit{most_file_bytes, most_file_bytes};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      ::signal(SIGXFSZ, SIG_IGN);
    }
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  return child;
}

std::vector<std::string> with(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

pid_t start(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  return start_words(with(CAIRN_PROGRAM, arguments), folder, RLIM_INFINITY);
}

Ran run(const std::vector<std::string>& words, const std::string& input, std::size_t most_file_bytes) {
  const TempDir dir;
  std::ofstream(dir.path() / "in", std::ios::binary) << input;
  const pid_t child = start_words(words, dir.path(), most_file_bytes);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(dir.path() / "out"),
          text_of(dir.path() / "err")};
}

}  // namespace

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Ran run_cairn(const std::vector<std::string>& arguments, const std::string& input) {
  return run(with(CAIRN_PROGRAM, arguments), input, RLIM_INFINITY);
}

Ran run_python(const std::vector<std::string>& arguments) {
  return run(with("/usr/bin/python3", arguments), "", RLIM_INFINITY);
}

Ran run_cairn_on_full_disk(const std::vector<std::string>& arguments, std::size_t most_bytes) {
  return run(with(CAIRN_PROGRAM, arguments), "", most_bytes);
}

bool run_cairn_and_kill(const std::vector<std::string>& arguments, std::chrono::milliseconds after) {
  const TempDir dir;
  std::ofstream(dir.path() / "in");
  const pid_t child = start(arguments, dir.path());
  std::this_thread::sleep_for(after);
  ::kill(child, SIGKILL);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return WIFSIGNALED(status);
}

std::optional<Ran> run_cairn_and_interrupt(const std::vector<std::string>& arguments,
                                           const std::filesystem::path& once_written) {
  constexpr std::uintmax_t kHeader = 16;
  const TempDir dir;
  std::ofstream(dir.path() / "in");
  const pid_t child = start(arguments, dir.path());
  int status = 0;
  bool ended = false;
  for (;;) {
    std::error_code error;
    const auto size = std::filesystem::file_size(once_written, error);
    if (!error && size > kHeader) break;
    ended = ::waitpid(child, &status, WNOHANG) == child;
    if (ended) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (!ended) {
    ::kill(child, SIGINT);
    REQUIRE(::waitpid(child, &status, 0) == child);
  }
  if (WIFEXITED(status)) return std::nullopt;
  return Ran{-1, text_of(dir.path() / "out"), text_of(dir.path() / "err")};
}

bool is_one_line(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

}  // namespace cairn::test
