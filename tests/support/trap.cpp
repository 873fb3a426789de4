#include "tests/support/trap.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>

// The functions of glibc, under the names that a replacement calls.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void __libc_free(void* memory);
}

namespace {

std::atomic<bool> watching{false};
std::atomic<std::uint64_t> heap_count{0};
thread_local bool is_trapped = false;

void note_heap_call() {
  if (is_trapped && watching) ++heap_count;
}

struct Call {
  int number = 0;
  std::uint64_t first = 0;
  std::uint64_t second = 0;
};
std::array<Call, 32> calls;
std::atomic<std::uint64_t> call_count{0};

// The registers of a trapped call: its first two arguments, and its result.
#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
std::uint64_t argument(const mcontext_t& machine, int index) {
  return static_cast<std::uint64_t>(machine.gregs[index == 0 ? REG_RDI : REG_RSI]);
}
void set_result(mcontext_t& machine, int result) { machine.gregs[REG_RAX] = result; }
#elif defined(__aarch64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
std::uint64_t argument(const mcontext_t& machine, int index) { return machine.regs[index]; }
void set_result(mcontext_t& machine, int result) {
  machine.regs[0] = static_cast<std::uint64_t>(std::int64_t{result});
}
#else
#error "tests/support/trap.cpp: the registers of this processor are not known here"
#endif

/// Called before the trapped call: its number and arguments are in the registers.
void on_trapped_call(int, siginfo_t* info, void* context) {
  mcontext_t& machine = static_cast<ucontext_t*>(context)->uc_mcontext;
  if (watching) {
    const std::uint64_t place = call_count++;
    if (place < calls.size()) calls[place] = {info->si_syscall, argument(machine, 0), argument(machine, 1)};
  }
  set_result(machine, -ENOSYS);
}

/// Returns the sockets, timers and event counters that the loop uses; no files.
std::vector<std::uint32_t> descriptors_of_the_loop() {
  std::vector<std::uint32_t> numbers;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (target.starts_with("socket:") || target == "anon_inode:[timerfd]" || target == "anon_inode:[eventfd]")
      numbers.push_back(static_cast<std::uint32_t>(std::stoul(entry.path().filename().string())));
  }
  return numbers;
}

constexpr std::array allowed_calls{
#ifdef SYS_epoll_wait  // missing on some processors
    SYS_epoll_wait,
#endif
    SYS_clock_gettime, SYS_epoll_pwait, SYS_epoll_ctl, SYS_timerfd_settime, SYS_recvmsg,
    SYS_recvmmsg,      SYS_sendmsg,     SYS_sendto,    SYS_timer_settime,   SYS_fcntl,
    SYS_rt_sigreturn,  SYS_exit,        SYS_exit_group};

sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
sock_filter verdict(std::uint32_t what) { return BPF_STMT(BPF_RET | BPF_K, what); }
/// Skips the next instruction unless the loaded number is `value`.
sock_filter next_if(std::uint32_t value) { return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1); }

std::vector<sock_filter> make_filter() {
  std::vector<sock_filter> filter{load(offsetof(seccomp_data, arch)),
                                  BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, architecture, 1, 0),
                                  verdict(SECCOMP_RET_KILL_PROCESS), load(offsetof(seccomp_data, nr))};
  for (const long call : allowed_calls) {
    filter.push_back(next_if(static_cast<std::uint32_t>(call)));
    filter.push_back(verdict(SECCOMP_RET_ALLOW));
  }
  const auto descriptors = descriptors_of_the_loop();
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_read, 2, 0));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_write, 1, 0));
  filter.push_back(verdict(SECCOMP_RET_TRAP));
  filter.push_back(load(offsetof(seccomp_data, args)));  // low half of the first argument, little-endian
  for (const std::uint32_t descriptor : descriptors) {
    filter.push_back(next_if(descriptor));
    filter.push_back(verdict(SECCOMP_RET_ALLOW));
  }
  filter.push_back(verdict(SECCOMP_RET_TRAP));
  return filter;
}

}  // namespace

// The heap of the whole program.
extern "C" {
void* malloc(std::size_t size) {
  note_heap_call();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  note_heap_call();
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  note_heap_call();
  return __libc_realloc(memory, size);
}
void free(void* memory) {
  if (memory != nullptr) note_heap_call();
  __libc_free(memory);
}
}

namespace hystcan::support {

std::string trap_this_thread() {
  is_trapped = true;
  struct sigaction action {};
  action.sa_sigaction = on_trapped_call;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  std::vector<sock_filter> filter = make_filter();
  const sock_fprog program{.len = static_cast<unsigned short>(filter.size()), .filter = filter.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
    return std::string("this kernel takes no seccomp filter: ") + std::strerror(errno);
  return {};
}

void watch(bool on) { watching = on; }

std::uint64_t trapped_call_count() { return call_count; }

std::vector<std::string> trapped_calls() {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < calls.size() && i < call_count; ++i) {
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "system call %d(0x%llx, 0x%llx)", calls[i].number,
                  static_cast<unsigned long long>(calls[i].first),
                  static_cast<unsigned long long>(calls[i].second));
    texts.emplace_back(text.data());
  }
  return texts;
}

std::uint64_t heap_calls() { return heap_count; }

}  // namespace hystcan::support
