#include "builder/serve/stream_service.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr int kSocket = 3;  // the descriptor of a connection in its process

bool has_token(std::string field, const char* token) {
  std::transform(field.begin(), field.end(), field.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; });
  return field.find(token) != std::string::npos;
}

/// What RFC 6455, section 4.2.1, asks of a key: 16 bytes in base 64.
bool is_key(const std::string& key) {
  const auto is_digit = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' || c == '/';
  };
  return key.size() == 24 && key.ends_with("==") && std::all_of(key.begin(), key.end() - 2, is_digit);
}

/// Starts a process that has the socket and no other connection of this one. Returns its number, 0 where it
/// cannot be started.
pid_t spawn_with_socket(std::vector<std::string> words, int socket) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, socket, kSocket);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kSocket + 1);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t process = 0;
  if (::posix_spawn(&process, words[0].c_str(), &actions, &attributes, arguments.data(), environ) != 0)
    process = 0;
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  return process;
}

}  // namespace

StreamService::StreamService(fs::path program, const StreamLimits& limits)
    : program_(std::move(program)), limits_(limits) {}

Result<std::unique_ptr<StreamService>> StreamService::create(const StreamLimits& limits) {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& place : {folder, folder / "../" CAIRN_LIBDIR "/cairn"}) {
    const fs::path program = place / "cairn-stream";
    if (::access(program.c_str(), X_OK) == 0)
      return std::unique_ptr<StreamService>(new StreamService(program, limits));
  }
  return failed(
      "stream: expected the program cairn-stream beside cairn, found none: it was built without the viewer");
}

StreamService::~StreamService() {
  // No other thread asks any more, but those that wait for processes still mark them.
  for (const auto& viewer : viewers_) {
    const std::lock_guard lock(mutex_);
    if (!viewer->ended) ::kill(viewer->process, SIGTERM);
  }
  for (const auto& viewer : viewers_) viewer->waits.join();
}

void StreamService::forget_ended() {
  std::erase_if(viewers_, [](const auto& viewer) {
    if (viewer->ended) viewer->waits.join();
    return viewer->ended;
  });
}

bool StreamService::has_place() {
  const std::lock_guard lock(mutex_);
  forget_ended();
  return viewers_.size() < static_cast<std::size_t>(limits_.viewers);
}

HttpAnswer StreamService::answer(const HttpRequest& request, const fs::path& pack) {
  if (!has_token(request.field("upgrade"), "websocket") ||
      !has_token(request.field("connection"), "upgrade") || request.field("sec-websocket-version") != "13") {
    HttpAnswer answer = error_answer(426, "stream: expected a request for a WebSocket of version 13");
    answer.fields.emplace_back("Upgrade", "websocket");
    answer.fields.emplace_back("Sec-WebSocket-Version", "13");
    return answer;
  }
  const std::string& key = request.field("sec-websocket-key");
  if (!is_key(key)) return error_answer(400, "stream: expected a key of 16 bytes in base 64");
  if (!has_place())
    return error_answer(503, "stream: expected at most " + std::to_string(limits_.viewers) +
                                 " viewers, found as many already");
  HttpAnswer answer;
  answer.take_socket = [this, key, pack](int socket) { start(socket, key, pack); };
  return answer;
}

void StreamService::start(int socket, const std::string& key, const fs::path& pack) {
  const std::lock_guard lock(mutex_);
  // Requests that came at once may all have found the last place.
  forget_ended();
  if (viewers_.size() < static_cast<std::size_t>(limits_.viewers)) {
    auto viewer = std::make_unique<Viewer>();
    viewer->process = spawn_with_socket(
        {program_.string(), pack.string(), std::to_string(kSocket), key, std::to_string(limits_.cache_mib)},
        socket);
    if (viewer->process != 0) {
      viewer->waits = std::thread([this, v = viewer.get()] {
        siginfo_t ended{};
        while (::waitid(P_PID, static_cast<id_t>(v->process), &ended, WEXITED | WNOWAIT) < 0 &&
               errno == EINTR) {
        }
        // Its number stays its own until it is marked, so that no other process is ended for it.
        const std::lock_guard marks(mutex_);
        ::waitpid(v->process, nullptr, 0);
        v->ended = true;
      });
      viewers_.push_back(std::move(viewer));
    }
  }
  ::close(socket);
}

}  // namespace cairn
