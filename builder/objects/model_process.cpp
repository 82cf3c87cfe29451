#include "builder/objects/model_process.h"

#include <array>
#include <cerrno>
#include <string>
#include <system_error>
#include <vector>

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOutput = std::size_t{1} << 30;
constexpr std::size_t kMostMessage = 2000;

/// The program, which lies beside the library or the program that this code is part of.
fs::path reader_program() {
  Dl_info self{};
  std::error_code error;
  fs::path library;
  if (::dladdr(reinterpret_cast<const void*>(&read_model_file), &self) != 0)
    library = fs::canonical(self.dli_fname, error).parent_path();
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {library, program, program / "../" CAIRN_LIBDIR "/cairn"}) {
    const fs::path file = folder / "cairn-model";
    if (!folder.empty() && fs::exists(file, error)) return file;
  }
  return {};
}

/// Both ends of a pipe, closed at the end.
struct Pipe {
  Pipe() {
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) ends = {-1, -1};
  }
  ~Pipe() {
    for (const int end : ends)
      if (end >= 0) ::close(end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_writing() {
    ::close(ends[1]);
    ends[1] = -1;
  }
  std::array<int, 2> ends{};
};

/// Reads both to their ends. What is beyond the limits is read and dropped.
void read_both(Pipe& output, Pipe& message, std::vector<std::byte>& bytes, std::string& text) {
  std::array<pollfd, 2> waits{{{output.ends[0], POLLIN, 0}, {message.ends[0], POLLIN, 0}}};
  std::vector<std::byte> buffer(std::size_t{1} << 16);
  while (waits[0].fd >= 0 || waits[1].fd >= 0) {
    if (::poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < waits.size(); ++i) {
      if (waits[i].fd < 0 || waits[i].revents == 0) continue;
      const auto got = ::read(waits[i].fd, buffer.data(), buffer.size());
      if (got <= 0) {
        waits[i].fd = -1;
        continue;
      }
      const auto count = static_cast<std::size_t>(got);
      if (i == 0 && bytes.size() + count <= kMostOutput)
        bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + got);
      if (i == 1 && text.size() < kMostMessage)
        text.append(reinterpret_cast<const char*>(buffer.data()), count);
    }
  }
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

Result<SourceMesh> read_in_process(const fs::path& file, bool is_image) {
  const std::string name = file.string();
  const std::string program = reader_program().string();
  if (program.empty())
    return failed(name +
                  ": expected the program cairn-model beside cairn, found none: it was built without assimp");
  Pipe output, message;
  if (output.ends[0] < 0 || message.ends[0] < 0) return failed(name + ": expected a pipe, found none free");
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, output.ends[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, message.ends[1], STDERR_FILENO);
  std::vector<std::string> words{program, is_image ? "image" : "model", name};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int spawned = ::posix_spawn(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (spawned != 0) return failed(name + ": " + program + ": " + std::generic_category().message(spawned));
  output.close_writing();
  message.close_writing();
  std::vector<std::byte> bytes;
  std::string text;
  read_both(output, message, bytes, text);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status))
    return bad_data(name + ": expected a model, found one that ended its reader by signal " +
                    std::to_string(WTERMSIG(status)));
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return bad_data(name + ": " + first_line(text));
  auto mesh = decode_mesh(bytes);
  if (!mesh) return bad_data(name + ": " + mesh.error().message);
  return mesh;
}

}  // namespace

Result<SourceMesh> read_model_file(const fs::path& file) {
  return read_in_process(file, false);
}

Result<SourceMesh> read_image_file(const fs::path& file) {
  return read_in_process(file, true);
}

}  // namespace cairn
