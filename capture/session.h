#pragma once
// Captures a light field of the box through whatever rig is plugged in, so that nothing is lost.
//
// A session is a dataset folder with session/journal.jsonl, to which every step is added as it
// happens (docs/capture.md lists the records). A frame counts once its file is whole on the disk
// and its record, with size and SHA-256, is in the journal; whatever ends the program before that,
// the frame is taken again. So the same call on the same folder goes on where the last one ended.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>

#include "capture/plan.h"
#include "core/dataset.h"

namespace wheatstone {

struct CaptureListener {
  std::function<void(const nlohmann::json& record)> on_record;  // as it stands in the journal
  std::function<void(int done, int total)> on_progress;         // frames
  std::stop_token stop;  // seen before every step, and by the devices during it
};

/// Carries out the plan in the order of shots_of(). Camera, lights and carriage never act at the
/// same time: the carriage moves only when the last frame has been read out. A frame is refused
/// unless the camera says that it was taken after it was asked for, by the rig's own camera and at
/// the exposure asked for. All frames of a view are taken from the same place: when a resumed
/// session cannot reach it within 0.02 mm, the view's earlier frames are set aside and taken again.
///
/// Writes raw/*.png, and when all are there frames.json and, last, `manifest` as dataset.json.
/// Files that are not what the journal says are moved to session/set_aside/, never deleted.
/// Lights are off and the carriage stands when it returns or throws, as far as the devices answer.
/// Errors: ArgumentError: the plan, or a session in this folder with another plan, rig or manifest
///           (the message lists what differs);
///         FileError: the folder holds another dataset or is in use, too little space, disk faults;
///         DeviceError: as the devices say, and kFault for a frame or a position that is not what
///           was asked for;
///         Cancelled: stop was requested.
void capture_light_field(const Rig&, const Dataset&, const DatasetManifest&, const CapturePlan&,
                         const CaptureListener&);

/// The plan of the session in this folder, as in its journal; nothing if there is no session.
/// Errors: FileError (journal damaged).
std::optional<CapturePlan> recorded_plan(const Dataset&);

/// What capture_light_field() would take, by the journal alone, without looking at the files.
/// Errors: as capture_light_field() for another plan, rig or manifest; FileError (journal damaged).
std::vector<Shot> missing_shots(const Rig&, const Dataset&, const DatasetManifest&,
                                const CapturePlan&);

}  // namespace wheatstone
