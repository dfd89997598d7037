//! The panic hook.

use std::panic;

/// Parry panics on some degenerate hulls. dcd-parry catches that and calls the pair
/// undecided; the message would only alarm. Every other panic is reported.
pub(crate) fn about_parry() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        let in_parry = panic.location().is_some_and(|place| place.file().contains("parry3d"));
        if !in_parry {
            report(panic);
        }
    }));
}
