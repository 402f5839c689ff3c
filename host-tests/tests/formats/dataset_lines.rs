//! The line in a refusal, among comments, blank lines and line ends of all kinds.

use proptest::prelude::*;

use crate::dataset_errors::{TOML, refused};

/// One physical line of a CSV that is not the bad one.
#[derive(Clone, Debug)]
enum Filler {
    Comment,
    IndentedComment,
    Blank,
    Spaces,
    Row,
}

proptest! {
    /// The reported line is the physical one, whatever is skipped before it and however lines end.
    #[test]
    fn the_line_is_exact(
        fillers in prop::collection::vec(
            prop_oneof![
                Just(Filler::Comment),
                Just(Filler::IndentedComment),
                Just(Filler::Blank),
                Just(Filler::Spaces),
                Just(Filler::Row),
            ],
            0..40,
        ),
        header_after in 0_usize..5,
        crlf in any::<bool>(),
        bom in any::<bool>(),
        last_line_ended in any::<bool>(),
    ) {
        let end = if crlf { "\r\n" } else { "\n" };
        let mut text = String::from(if bom { "\u{feff}" } else { "" });
        let mut line = 1;
        for _ in 0..header_after {
            text += "# \"what, ever";
            text += end;
            line += 1;
        }
        text += "time_s,input_v,displacement_um";
        for (row, filler) in fillers.iter().enumerate() {
            text += end;
            line += 1;
            match filler {
                Filler::Comment => text += "# note, \"one",
                Filler::IndentedComment => text += "  # note, two",
                Filler::Blank => {}
                Filler::Spaces => text += " \t ",
                Filler::Row => text += &format!(" {row} , 1.5,\"2.5\" "),
            }
        }
        text += end;
        line += 1;
        text += "99,oops,1";
        if last_line_ended {
            text += end;
        }
        prop_assert_eq!(
            refused(TOML, text),
            format!("a.csv:{line}: column input_v: \"oops\" is not a number; remove or repair the row")
        );
    }
}
