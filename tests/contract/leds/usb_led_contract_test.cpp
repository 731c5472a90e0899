// The contract of LED arrays on a Fadecandy, of the firmware that counts frames and of the one that
// does not.

#include "tests/contract/leds/led_contract.h"
#include "tests/contract/leds/usb_led_backend.h"

namespace wheatstone {
namespace {

const LedMaker kMakers[] = {{"Fadecandy", [] { return std::make_unique<FadecandyBackend>(); }},
                            {"FadecandyThatDoesNotCount", [] {
                               FadecandyFirmwareOptions options;
                               options.counts_frames = false;
                               return std::make_unique<FadecandyBackend>(options);
                             }}};
INSTANTIATE_TEST_SUITE_P(Leds, LedContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace wheatstone
