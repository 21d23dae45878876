#pragma once

#include <unistd.h>

#include <cerrno>
#include <string>

namespace ugoki::plugin {

/// Reads the available bytes of a non-blocking pipe. @return false at the end of the pipe
inline bool drain(int fd, std::string& to) {
  char buffer[4096];
  while (true) {
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n > 0)
      to.append(buffer, static_cast<std::size_t>(n));
    else if (n == 0)
      return false;
    else if (errno != EINTR)
      return errno == EAGAIN;
  }
}

}  // namespace ugoki::plugin
