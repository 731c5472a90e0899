#pragma once
// What a call says when it fails.

#include <string>

#include "core/error.h"

namespace wheatstone {

/// The text of the wheatstone::Error that call() throws, "no error" without one.
template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace wheatstone
