#pragma once
// The bytes of streaming ACN (ANSI E1.31-2018).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

inline constexpr int kE131Port = 5568, kE131Slots = 512, kE131LastUniverse = 63999;
inline constexpr std::size_t kE131DataSequenceAt = 111, kE131OptionsAt = 112,
                             kE131SyncSequenceAt = 44;
inline constexpr std::uint8_t kE131Terminated = 0x40;

struct E131Source {
  std::array<std::uint8_t, 16> id{};  // the same at each start, so that receivers know it again
  std::string name;                   // at most 63 bytes of it are sent
  int priority = 100;
};

/// Sequence number 0, no options. `sync_universe` 0: to be shown at once. At most 512 slots.
std::vector<std::uint8_t> e131_data(const E131Source&, int universe, int sync_universe,
                                    std::span<const std::uint8_t> slots);
/// What was sent with this sync universe shall show now.
std::vector<std::uint8_t> e131_sync(const E131Source&, int sync_universe);
/// "239.255.hi.lo".
std::string e131_multicast_address(int universe);

}  // namespace wheatstone
