// SPDX-License-Identifier: Apache-2.0
#include "station/jobs/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/file_descriptor.h"

namespace soak::station {
namespace {

constexpr int kNice = 10;
constexpr std::string_view kFirstToGo = "500";  // of 1000: before anything else of the machine (proc(5), oom_score_adj)
constexpr int kNotStarted = 127;
constexpr int kLookEvery_ms = 50;
constexpr std::chrono::seconds kToFinish{3};

base::Error failure(const std::string& what) {
  return {base::ErrorKind::internal, what + ": " + std::generic_category().message(errno), "jobs"};
}

/// What exec() takes, made before fork(): afterwards no memory may be had.
class CommandLine {
 public:
  CommandLine(const ChildProgram& child, bool tells_progress) {
    words_.push_back(child.program.string());
    words_.insert(words_.end(), child.arguments.begin(), child.arguments.end());
    for (char** entry = environ; *entry != nullptr; ++entry) {
      if (!std::string_view(*entry).starts_with("USER=")) variables_.emplace_back(*entry);
    }
    variables_.push_back("USER=" + child.user);
    if (tells_progress) variables_.emplace_back("SOAK_PROGRESS=1");
    for (std::string& word : words_) argv_.push_back(word.data());
    for (std::string& variable : variables_) envp_.push_back(variable.data());
    argv_.push_back(nullptr);
    envp_.push_back(nullptr);
  }
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine() = default;

  void carry_out() const { ::execve(argv_.front(), argv_.data(), envp_.data()); }

 private:
  std::vector<std::string> words_;
  std::vector<std::string> variables_;
  std::vector<char*> argv_;
  std::vector<char*> envp_;
};

struct Pipe {
  base::FileDescriptor read;
  base::FileDescriptor write;
};

base::Result<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return tl::unexpected(failure("no pipe for a job"));
  Pipe pipe{base::FileDescriptor(ends[0]), base::FileDescriptor(ends[1])};
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  return pipe;
}

/// The new process. Only calls that are safe after fork() in a process with threads (signal-safety(7)).
[[noreturn]] void become(const CommandLine& command, int null, int out, int err, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kNotStarted);
  // What soakd blocks and ignores would stay so.
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_DFL);
  if (::nice(kNice) == -1) {
    // It runs all the same, as soakd's equal.
  }
  const int score = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (score >= 0 && ::write(score, kFirstToGo.data(), kFirstToGo.size()) < 0) {
    // Nor does it need this.
  }
  if (::dup2(null, STDIN_FILENO) < 0 || ::dup2(out, STDOUT_FILENO) < 0 || ::dup2(err, STDERR_FILENO) < 0) {
    ::_exit(kNotStarted);
  }
  ::closefrom(STDERR_FILENO + 1);
  command.carry_out();
  ::_exit(kNotStarted);
}

/// One of its outputs, up to a limit; what is beyond is read and left out, so that it goes on.
class Collected {
 public:
  Collected(base::FileDescriptor end, std::size_t most) : end_(std::move(end)), most_(most) {}

  [[nodiscard]] pollfd awaited() const { return {end_.get(), POLLIN, 0}; }  // −1, once it is closed, is passed over
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  [[nodiscard]] std::string_view text() const { return text_; }
  std::string take() { return std::move(text_); }

  /// Reads what there is.
  void read() {
    std::array<char, 65536> buffer{};
    while (end_) {
      const ssize_t n = ::read(end_.get(), buffer.data(), buffer.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) return;
      if (n <= 0) return end_.reset();
      const std::size_t fits = std::min(static_cast<std::size_t>(n), most_ - text_.size());
      text_.append(buffer.data(), fits);
      is_whole_ = is_whole_ && fits == static_cast<std::size_t>(n);
    }
  }

 private:
  base::FileDescriptor end_;
  std::size_t most_;
  std::string text_;
  bool is_whole_ = true;
};

/// Asks the process to end once it shall stop, and ends it where it has not done so in time.
class Stopper {
 public:
  explicit Stopper(pid_t process) : process_(process) {}

  [[nodiscard]] bool has_asked() const { return has_asked_; }
  void stop() {
    const auto now = std::chrono::steady_clock::now();
    if (!std::exchange(has_asked_, true)) {
      latest_end_ = now + kToFinish;
      ::kill(process_, SIGTERM);
    } else if (now >= latest_end_) {
      ::kill(process_, SIGKILL);
    }
  }

 private:
  pid_t process_;
  bool has_asked_ = false;
  std::chrono::steady_clock::time_point latest_end_;
};

int exit_status_of(int status) { return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status); }

ChildEnd follow(pid_t process, Collected output, Collected errors, const std::atomic<bool>& stop,
                const std::function<void(std::string_view)>& hear) {
  Stopper stopper(process);
  std::size_t heard = 0;
  for (;;) {
    std::array<pollfd, 2> awaited = {output.awaited(), errors.awaited()};
    ::poll(awaited.data(), awaited.size(), kLookEvery_ms);
    output.read();
    errors.read();
    if (hear && std::exchange(heard, errors.text().size()) != errors.text().size()) hear(errors.text());
    if (stop) stopper.stop();
    int status = 0;
    const pid_t ended = ::waitpid(process, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) continue;
    output.read();
    errors.read();
    const bool is_whole = output.is_whole() && errors.is_whole();
    return {ended < 0 ? kNotStarted : exit_status_of(status), output.take(), errors.take(), is_whole,
            stopper.has_asked()};
  }
}

}  // namespace

base::Result<ChildEnd> run_child(const ChildProgram& child, const std::atomic<bool>& stop,
                                 const std::function<void(std::string_view errors)>& hear) {
  errno = 0;
  if (::access(child.program.c_str(), X_OK) != 0) {
    return tl::unexpected(failure("cannot run " + child.program.string()));
  }
  const base::FileDescriptor null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (!null) return tl::unexpected(failure("cannot open /dev/null"));
  auto out = make_pipe();
  if (!out) return base::forward_error(out);
  auto err = make_pipe();
  if (!err) return base::forward_error(err);
  const CommandLine command(child, static_cast<bool>(hear));
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) return tl::unexpected(failure("cannot start a process"));
  if (process == 0) become(command, null.get(), out->write.get(), err->write.get(), parent);
  out->write.reset();
  err->write.reset();
  return follow(process, Collected(std::move(out->read), kMostOutput), Collected(std::move(err->read), kMostErrors),
                stop, hear);
}

}  // namespace soak::station
