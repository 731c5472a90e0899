#pragma once
// Quantities as types. Interfaces and configurations use these; inner loops unwrap with value().

#include <compare>

namespace wheatstone {

/// A double that remembers what it measures, in the unit named beside its alias.
template <class Tag>
class Quantity {
 public:
  constexpr Quantity() = default;
  static constexpr Quantity of(double v) {
    Quantity q;
    q.value_ = v;
    return q;
  }
  constexpr double value() const { return value_; }

  friend constexpr Quantity operator+(Quantity a, Quantity b) { return of(a.value_ + b.value_); }
  friend constexpr Quantity operator-(Quantity a, Quantity b) { return of(a.value_ - b.value_); }
  friend constexpr Quantity operator*(double k, Quantity a) { return of(k * a.value_); }
  friend constexpr double operator/(Quantity a, Quantity b) { return a.value_ / b.value_; }
  friend constexpr auto operator<=>(Quantity, Quantity) = default;

 private:
  double value_ = 0.0;
};

using Length = Quantity<struct LengthTag>;        // mm
using Vergence = Quantity<struct VergenceTag>;    // dioptre, 1/m
using Luminance = Quantity<struct LuminanceTag>;  // cd/m^2
using Duration = Quantity<struct DurationTag>;    // s
using Angle = Quantity<struct AngleTag>;          // rad

constexpr Length operator""_mm(long double v) {
  return Length::of(static_cast<double>(v));
}
constexpr Vergence operator""_D(long double v) {
  return Vergence::of(static_cast<double>(v));
}
constexpr Luminance operator""_cd_m2(long double v) {
  return Luminance::of(static_cast<double>(v));
}
constexpr Duration operator""_s(long double v) {
  return Duration::of(static_cast<double>(v));
}

constexpr Angle degrees(double deg) {
  return Angle::of(deg * 3.14159265358979323846 / 180);
}
constexpr double to_degrees(Angle a) {
  return a.value() * 180 / 3.14159265358979323846;
}

/// Focal distance of a plane `distance` away from the eye. Pre: distance > 0 mm.
constexpr Vergence vergence_at(Length distance) {
  return Vergence::of(1000.0 / distance.value());
}
static_assert(vergence_at(400.0_mm) == 2.5_D);

}  // namespace wheatstone
