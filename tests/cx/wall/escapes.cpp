#include "escapes.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <linux/io_uring.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/ipc.h>
#include <sys/mount.h>
#include <sys/msg.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/sem.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

extern char** environ;

namespace cxlab::test {

namespace {

using T = Targets;

std::string secret(const T& t) { return t.outside / "secret.txt"; }
std::string victim(const T& t) { return t.outside / "victim.txt"; }
std::string known(const T& t) { return t.package / "known.txt"; }
std::string own(const T& t) { return t.run / "own.txt"; }

bool opens(const std::string& path, int flags) {
  const int file = open(path.c_str(), flags | O_CLOEXEC, 0644);
  if (file >= 0) close(file);
  return file >= 0;
}
bool reads(const std::string& path) { return opens(path, O_RDONLY); }

/// Whether a child came to be; it ends at once.
bool forked(long pid) {
  if (pid == 0) _exit(0);
  if (pid > 0) waitpid(static_cast<pid_t>(pid), nullptr, 0);
  return pid > 0;
}

bool ran(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

bool opens_socket(int family, int type, int protocol = 0) {
  const int made = socket(family, type, protocol);
  if (made >= 0) close(made);
  return made >= 0;
}

bool connects_to_path(const T& t) {
  const int made = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::snprintf(address.sun_path, sizeof address.sun_path, "%s", (t.outside / "server.sock").c_str());
  const bool done = connect(made, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(made);
  return done;
}

bool sends_to_port(const T& t) {
  const int made = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(t.port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool done = connect(made, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(made);
  return done;
}

/// A program that is written into memory, or into the run, and started.
bool starts_own_program(const T& t, bool in_memory) {
  const std::string path = t.run / "program";
  const int file = in_memory ? static_cast<int>(syscall(SYS_memfd_create, "program", 0))
                             : open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0755);
  const char script[] = "#!/bin/sh\nexit 0\n";
  if (file < 0 || write(file, script, sizeof script - 1) < 0) return false;
  const std::string self = "/proc/self/fd/" + std::to_string(file);
  const long pid = syscall(SYS_fork);
  if (pid == 0) {
    char* argv[] = {const_cast<char*>("program"), nullptr};
    execve(in_memory ? self.c_str() : path.c_str(), argv, environ);
    _exit(1);
  }
  if (pid < 0) {  // without a new process: in this one's place, which only fails
    char* argv[] = {const_cast<char*>("program"), nullptr};
    execve(in_memory ? self.c_str() : path.c_str(), argv, environ);
    return false;
  }
  int status = 0;
  waitpid(static_cast<pid_t>(pid), &status, 0);
  return in_memory || ran(status) || WIFEXITED(status);
}

constexpr unsigned kHandleBytes = 128;
struct Handle {
  file_handle head;
  unsigned char bytes[kHandleBytes];
};

const Escape kEscapes[] = {
    // --- reading
    {"read a file", [](const T& t) { return reads(secret(t)); }},
    {"read the list of users", [](const T&) { return reads("/etc/passwd"); }},
    {"read from a package upwards",
     [](const T& t) { return reads(t.package / ".." / t.outside.filename() / "secret.txt"); }},
    {"read from the run upwards", [](const T& t) { return reads(t.run / ".." / t.outside.filename() / "secret.txt"); }},
    {"read through /proc/self/root", [](const T& t) { return reads("/proc/self/root" + secret(t)); }},
    {"read through /proc/self/cwd",
     [](const T& t) { return chdir(t.outside.c_str()) == 0 && reads("/proc/self/cwd/secret.txt"); }},
    {"read what is open as a path",
     [](const T& t) {
       const int path = open(secret(t).c_str(), O_PATH);
       return path >= 0 && reads("/proc/self/fd/" + std::to_string(path));
     }},
    {"read with openat2",
     [](const T& t) {
       std::uint64_t how[3] = {O_RDONLY, 0, 0};
       return syscall(SYS_openat2, AT_FDCWD, secret(t).c_str(), how, sizeof how) >= 0;
     }},
    {"list a folder",
     [](const T& t) {
       DIR* folder = opendir(t.outside.c_str());
       if (folder) closedir(folder);
       return folder != nullptr;
     }},
    {"read by a handle",
     [](const T& t) {
       Handle handle{};
       handle.head.handle_bytes = kHandleBytes;
       int mount = 0;
       if (name_to_handle_at(AT_FDCWD, secret(t).c_str(), &handle.head, &mount, 0) != 0) return false;
       const int root = open("/", O_RDONLY | O_DIRECTORY);
       return open_by_handle_at(root, &handle.head, O_RDONLY) >= 0;
     },
     false},
    {"read the environment of a process",
     [](const T& t) { return reads("/proc/" + std::to_string(t.other) + "/environ"); }},
    {"read the memory of a process", [](const T& t) { return reads("/proc/" + std::to_string(t.other) + "/mem"); }},
    {"watch a folder",
     [](const T& t) {
       const int watch = inotify_init();
       return watch >= 0 && inotify_add_watch(watch, t.outside.c_str(), IN_ALL_EVENTS) >= 0;
     }},
    {"read the kernel's log", [](const T&) { return reads("/dev/kmsg"); }, false},

    // --- writing
    {"write a file", [](const T& t) { return opens(victim(t), O_WRONLY); }},
    {"write to a package", [](const T& t) { return opens(known(t), O_RDWR); }},
    {"make a file", [](const T& t) { return opens(t.outside / "new.txt", O_WRONLY | O_CREAT); }},
    {"make a file in a package", [](const T& t) { return opens(t.package / "new.txt", O_WRONLY | O_CREAT); }},
    {"make a file without a name", [](const T& t) { return opens(t.outside, O_WRONLY | O_TMPFILE); }},
    {"make a file in the temporary folder",
     [](const T&) {
       char name[] = "/tmp/cxlab-escape-XXXXXX";
       const int file = mkstemp(name);
       if (file >= 0) unlink(name);
       return file >= 0;
     }},
    {"empty a file", [](const T& t) { return truncate(victim(t).c_str(), 0) == 0; }},
    {"empty a file of a package", [](const T& t) { return truncate(known(t).c_str(), 0) == 0; }},
    {"empty a file of a package on opening", [](const T& t) { return opens(known(t), O_RDONLY | O_TRUNC); }},
    {"make a folder", [](const T& t) { return mkdir((t.outside / "folder").c_str(), 0755) == 0; }},
    {"remove a folder", [](const T& t) { return rmdir((t.outside / "empty").c_str()) == 0; }},
    {"remove a file", [](const T& t) { return unlink(victim(t).c_str()) == 0; }},
    {"remove a file of a package", [](const T& t) { return unlink(known(t).c_str()) == 0; }},
    {"move a file out", [](const T& t) { return rename(own(t).c_str(), (t.outside / "moved").c_str()) == 0; }},
    {"move a file in", [](const T& t) { return rename(secret(t).c_str(), (t.run / "moved").c_str()) == 0; }},
    {"move a file of a package in",
     [](const T& t) { return rename(known(t).c_str(), (t.run / "moved").c_str()) == 0; }},
    {"exchange two files",
     [](const T& t) { return renameat2(AT_FDCWD, own(t).c_str(), AT_FDCWD, victim(t).c_str(), RENAME_EXCHANGE) == 0; }},
    {"link a file in", [](const T& t) { return link(secret(t).c_str(), (t.run / "link").c_str()) == 0; }},
    {"link a file out", [](const T& t) { return link(own(t).c_str(), (t.outside / "link").c_str()) == 0; }},
    {"make a symbolic link in the run",
     [](const T& t) { return symlink(secret(t).c_str(), (t.run / "link").c_str()) == 0; }},
    {"make a pipe with a name", [](const T& t) { return mkfifo((t.run / "fifo").c_str(), 0644) == 0; }},
    {"make a device", [](const T& t) { return mknod((t.run / "device").c_str(), S_IFCHR | 0666, makedev(1, 8)) == 0; },
     false},
    {"change rights", [](const T& t) { return chmod(victim(t).c_str(), 0777) == 0; }},
    {"change rights of a file that is open",
     [](const T& t) { return fchmod(open(known(t).c_str(), O_RDONLY), 0777) == 0; }},
    {"change rights below a folder", [](const T& t) { return fchmodat(AT_FDCWD, victim(t).c_str(), 0777, 0) == 0; }},
    {"change an owner", [](const T& t) { return chown(victim(t).c_str(), getuid(), getgid()) == 0; }},
    {"change an owner of a link", [](const T& t) { return lchown(victim(t).c_str(), getuid(), getgid()) == 0; }},
    {"change times", [](const T& t) { return utimensat(AT_FDCWD, victim(t).c_str(), nullptr, 0) == 0; }},
    {"change times of a file that is open",
     [](const T& t) { return futimens(open(known(t).c_str(), O_RDONLY), nullptr) == 0; }},
    {"change times in the old way", [](const T& t) { return utimes(victim(t).c_str(), nullptr) == 0; }},
    {"set an attribute", [](const T& t) { return setxattr(victim(t).c_str(), "user.a", "b", 1, 0) == 0; }, false},
    {"remove an attribute", [](const T& t) { return removexattr(victim(t).c_str(), "user.a") == 0; }, false},

    // --- programs and processes
    {"fork", [](const T&) { return forked(syscall(SYS_fork)); }},
    {"vfork", [](const T&) { return forked(syscall(SYS_clone, SIGCHLD, nullptr, nullptr, nullptr, 0)); }},
    {"clone3",
     [](const T&) {
       std::uint64_t arguments[8] = {0, 0, 0, 0, SIGCHLD, 0, 0, 0};
       return forked(syscall(SYS_clone3, arguments, sizeof arguments));
     }},
    {"start a program",
     [](const T&) {
       pid_t pid = 0;
       char* argv[] = {const_cast<char*>("true"), nullptr};
       int status = 0;
       return posix_spawn(&pid, "/bin/true", nullptr, nullptr, argv, environ) == 0 && waitpid(pid, &status, 0) == pid &&
              ran(status);
     }},
    {"start a command of the shell", [](const T&) { return system("exit 0") == 0; }},
    {"start a program in memory", [](const T& t) { return starts_own_program(t, true); }},
    {"start a program in the run", [](const T& t) { return starts_own_program(t, false); }},
    {"signal a process", [](const T& t) { return kill(t.other, 0) == 0; }},
    {"signal a group", [](const T&) { return kill(0, 0) == 0; }},
    {"signal all processes", [](const T&) { return kill(-1, 0) == 0; }},
    {"signal a thread", [](const T& t) { return syscall(SYS_tkill, t.other, 0) == 0; }},
    {"signal a thread of a process", [](const T& t) { return syscall(SYS_tgkill, t.other, t.other, 0) == 0; }},
    {"signal by a descriptor",
     [](const T& t) {
       const long file = syscall(SYS_pidfd_open, t.other, 0);
       return file >= 0 && syscall(SYS_pidfd_send_signal, file, 0, nullptr, 0) == 0;
     }},
    {"signal by a queue",
     [](const T& t) {
       sigval value{};
       return sigqueue(t.other, 0, value) == 0;
     }},
    {"let a file signal a process",
     [](const T& t) {
       int ends[2];
       return pipe(ends) == 0 && fcntl(ends[0], F_SETOWN, t.other) == 0;
     }},
    {"let a file signal a process by ioctl",
     [](const T& t) {
       int ends[2];
       const int owner = t.other;
       return pipe(ends) == 0 && ioctl(ends[0], FIOSETOWN, &owner) == 0;
     },
     false},
    {"trace a process",
     [](const T& t) {
       const bool done = ptrace(PTRACE_SEIZE, t.other, nullptr, nullptr) == 0;
       if (done) ptrace(PTRACE_DETACH, t.other, nullptr, nullptr);
       return done;
     },
     false},
    {"read out of a process",
     [](const T& t) {
       char here[8];
       iovec local{here, sizeof here}, remote{here, sizeof here};
       return process_vm_readv(t.other, &local, 1, &remote, 1, 0) >= 0;
     },
     false},
    {"write into a process",
     [](const T& t) {
       char here[8]{};
       iovec local{here, sizeof here}, remote{here, sizeof here};
       return process_vm_writev(t.other, &local, 1, &remote, 1, 0) >= 0;
     },
     false},
    {"limit a process",
     [](const T& t) {
       rlimit now{};
       return prlimit(t.other, RLIMIT_CORE, nullptr, &now) == 0;
     }},
    {"slow a process down", [](const T& t) { return setpriority(PRIO_PROCESS, static_cast<id_t>(t.other), 19) == 0; }},
    {"move a process to a core",
     [](const T& t) {
       cpu_set_t cores;
       return sched_getaffinity(t.other, sizeof cores, &cores) == 0 &&
              sched_setaffinity(t.other, sizeof cores, &cores) == 0;
     }},
    {"take a descriptor of a process",
     [](const T& t) {
       const long file = syscall(SYS_pidfd_open, t.other, 0);
       return file >= 0 && syscall(SYS_pidfd_getfd, file, 0, 0) >= 0;
     },
     false},

    // --- sockets
    {"connect by TCP", sends_to_port},
    {"open TCP", [](const T&) { return opens_socket(AF_INET, SOCK_STREAM); }},
    {"open TCP 6", [](const T&) { return opens_socket(AF_INET6, SOCK_STREAM); }, false},
    {"open UDP", [](const T&) { return opens_socket(AF_INET, SOCK_DGRAM); }},
    {"open a Unix socket", [](const T&) { return opens_socket(AF_UNIX, SOCK_STREAM); }},
    {"connect to a Unix socket", connects_to_path},
    {"open Netlink", [](const T&) { return opens_socket(AF_NETLINK, SOCK_RAW); }},
    {"open packets", [](const T&) { return opens_socket(AF_PACKET, SOCK_RAW); }, false},
    {"open a raw socket", [](const T&) { return opens_socket(AF_INET, SOCK_RAW, IPPROTO_ICMP); }, false},
    {"open a socket of a virtual machine", [](const T&) { return opens_socket(AF_VSOCK, SOCK_STREAM); }, false},

    // --- the kernel
    {"io_uring",
     [](const T&) {
       io_uring_params parameters{};
       return syscall(SYS_io_uring_setup, 1, &parameters) >= 0;
     },
     false},
    {"bpf", [](const T&) { return syscall(SYS_bpf, 0, nullptr, 0) >= 0 || errno == EINVAL || errno == EFAULT; }, false},
    {"perf", [](const T&) { return syscall(SYS_perf_event_open, nullptr, 0, -1, -1, 0) >= 0 || errno == EFAULT; },
     false},
    {"userfaultfd", [](const T&) { return syscall(SYS_userfaultfd, O_CLOEXEC) >= 0; }, false},
    {"keys", [](const T&) { return syscall(SYS_keyctl, 0, -3, 0) >= 0; }, false},
    {"leave the name space", [](const T&) { return unshare(CLONE_NEWUSER) == 0; }, false},
    {"mount", [](const T& t) { return mount("none", t.run.c_str(), "tmpfs", 0, nullptr) == 0; }, false},
    {"change the root", [](const T& t) { return chroot(t.outside.c_str()) == 0; }, false},
    {"shared memory", [](const T&) { return shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600) >= 0; }, false},
    {"messages", [](const T&) { return msgget(IPC_PRIVATE, IPC_CREAT | 0600) >= 0; }, false},
    {"semaphores", [](const T&) { return semget(IPC_PRIVATE, 1, IPC_CREAT | 0600) >= 0; }, false},
    {"become somebody else", [](const T&) { return setuid(65534) == 0; }, false},
    {"let somebody trace it", [](const T&) { return prctl(PR_SET_DUMPABLE, 1) == 0; }},
    {"type at the terminal",
     [](const T&) {
       const char letter = 'x';
       for (const int stream : {0, 1, 2})
         if (ioctl(stream, TIOCSTI, &letter) == 0) return true;
       return errno != EPERM;
     },
     false},
    {"set the clock",
     [](const T&) {
       timeval now{};
       gettimeofday(&now, nullptr);
       return settimeofday(&now, nullptr) == 0;
     },
     false},
    {"name the machine", [](const T&) { return sethostname("", 0) == 0; }, false},
};

}  // namespace

std::span<const Escape> escapes() { return kEscapes; }

}  // namespace cxlab::test
