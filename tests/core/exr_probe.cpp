// exr_probe read|views FILE: reads a file that may be hostile, with 5 s of processor time and 2 GiB
// of memory. Exit status 0: it was read, or refused with FileError. A program of its own, because
// a forked child would lack the threads that OpenEXR has started in its parent.
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "core/error.h"
#include "core/exr.h"

int main(int argc, char** argv) {
  if (argc != 3) return 3;
  const rlimit cpu{5, 5};
  setrlimit(RLIMIT_CPU, &cpu);
#ifndef __SANITIZE_ADDRESS__  // it reserves terabytes of address space
  std::ifstream pages("/proc/self/statm");
  rlim_t own_pages = 0;
  pages >> own_pages;
  const rlim_t bytes = own_pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t{2} << 30);
  const rlimit memory{bytes, bytes};
  setrlimit(RLIMIT_AS, &memory);
#endif
  try {
    if (std::string(argv[1]) == "views")
      wheatstone::read_exr_views(argv[2]);
    else
      wheatstone::read_exr(argv[2]);
  } catch (const wheatstone::FileError&) {
  } catch (...) {
    return 2;
  }
  return 0;
}
