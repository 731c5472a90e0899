#pragma once

#include <span>
#include <vector>

#include "tests/contract/display_outputs_faults.h"
#include "tests/contract/head_tracker_faults.h"
#include "tests/contract/leds/led_faults.h"
#include "tests/contract/light_sensor_faults.h"
#include "tests/contract/lights/lights_faults.h"
#include "tests/contract/spectroradiometer_faults.h"
#include "tests/contract/stage_faults.h"
#include "tests/contract/still/still_faults.h"
#include "tests/contract/video/video_faults.h"

namespace wheatstone {

/// Every table of faults, by driver.
inline std::vector<std::span<const FaultCase>> all_faults() {
  return {kGrblFaults,
          kArduinoGantryFaults,
          kGphotoFaults,
          kReplayFaults,
          kV4l2Faults,
          kHidRelayFaults,
          kBlink1Faults,
          kFadecandyFaults,
          kE131Faults,
          kJetiFaults,
          kSpotreadFaults,
          kXrandrFaults,
          kPhotodiodeFaults,
          kSerialHeadTrackerFaults,
          kUdpHeadTrackerFaults,
          kSimulatedStageFaults,
          kSimulatedStillFaults,
          kSimulatedVideoFaults,
          kSimulatedMarkersFaults,
          kSimulatedLedFaults,
          kSimulatedLightSensorFaults,
          kSimulatedHeadTrackerFaults,
          kSimulatedMeterFaults,
          kSimulatedOutputFaults};
}

}  // namespace wheatstone
