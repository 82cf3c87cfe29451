#include "builder/app/interrupt.h"

#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <signal.h>
#include <unistd.h>

namespace cairn {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

// A signal's handler reaches nothing but a variable of the program.
volatile std::sig_atomic_t signal_that_came = 0;

void keep_signal(int number) {
  signal_that_came = number;
  constexpr char kText[] = "\ncairn: ends after the tiles at work; again to end at once\n";
  if (::isatty(STDERR_FILENO) == 1) (void)!::write(STDERR_FILENO, kText, std::strlen(kText));
}

}  // namespace

Interrupt::Interrupt() {
  signal_that_came = 0;
  for (const int number : kSignals) {
    struct sigaction before {};
    // One that is ignored (nohup) stays so.
    if (::sigaction(number, nullptr, &before) != 0 || before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = keep_signal;
    action.sa_flags = SA_RESETHAND | SA_RESTART;
    ::sigaction(number, &action, nullptr);
  }
}

Interrupt::~Interrupt() {
  for (const int number : kSignals) {
    struct sigaction now {};
    if (::sigaction(number, nullptr, &now) == 0 && now.sa_handler == keep_signal) ::signal(number, SIG_DFL);
  }
}

bool Interrupt::is_asked() const {
  return signal_that_came != 0;
}

void Interrupt::end_program() const {
  if (signal_that_came == 0) return;
  std::fflush(nullptr);
  ::signal(signal_that_came, SIG_DFL);
  ::raise(signal_that_came);
}

}  // namespace cairn
