//! Transfer syntaxes: how a data set and its pixels are encoded.

use dicom_dictionary_std::uids;
use dicom_encoding::TransferSyntaxIndex as _;
use dicom_encoding::transfer_syntax::TransferSyntax;
use dicom_transfer_syntax_registry::TransferSyntaxRegistry;

use crate::formats::Checked;

/// How the pixels of a frame are encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    Native { big_endian: bool },
    Rle,
    Jpeg,
    JpegLs,
    Jpeg2000,
}

/// A transfer syntax that is read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Syntax {
    /// Whether the data set is deflated.
    pub(super) deflated: bool,
    pub(super) codec: Codec,
    uid: &'static str,
}

/// Those that are read. All but the first and the third are explicit VR little endian.
const SYNTAXES: [Syntax; 13] = {
    use Codec::{Jpeg, Jpeg2000, JpegLs, Native, Rle};
    const fn plain(uid: &'static str, codec: Codec) -> Syntax {
        Syntax { deflated: false, codec, uid }
    }
    let native = Native { big_endian: false };
    [
        plain(uids::IMPLICIT_VR_LITTLE_ENDIAN, native),
        plain(uids::EXPLICIT_VR_LITTLE_ENDIAN, native),
        #[allow(deprecated, reason = "retired, but files have it")]
        plain(uids::EXPLICIT_VR_BIG_ENDIAN, Native { big_endian: true }),
        Syntax { deflated: true, codec: native, uid: uids::DEFLATED_EXPLICIT_VR_LITTLE_ENDIAN },
        plain(uids::RLE_LOSSLESS, Rle),
        plain(uids::JPEG_BASELINE8_BIT, Jpeg),
        plain(uids::JPEG_EXTENDED12_BIT, Jpeg),
        plain(uids::JPEG_LOSSLESS, Jpeg),
        plain(uids::JPEG_LOSSLESS_SV1, Jpeg),
        plain(uids::JPEGLS_LOSSLESS, JpegLs),
        plain(uids::JPEGLS_NEAR_LOSSLESS, JpegLs),
        plain(uids::JPEG2000_LOSSLESS, Jpeg2000),
        plain(uids::JPEG2000, Jpeg2000),
    ]
};

impl Syntax {
    /// By its UID.
    pub(super) fn from_uid(uid: &str) -> Checked<Self> {
        SYNTAXES.into_iter().find(|syntax| syntax.uid == uid).ok_or_else(|| {
            let name = TransferSyntaxRegistry.get(uid).map_or("unknown", |syntax| syntax.name());
            format!(
                "TransferSyntaxUID is {uid} ({name}); valid: uncompressed, deflated, RLE, JPEG, JPEG-LS, JPEG 2000; \
                 convert it, for example with: gdcmconv --raw"
            )
        })
    }

    /// How the elements of the data set are encoded, once it is inflated.
    pub(super) fn elements(&self) -> Checked<&'static TransferSyntax> {
        let uid = if self.deflated { uids::EXPLICIT_VR_LITTLE_ENDIAN } else { self.uid };
        TransferSyntaxRegistry.get(uid).ok_or_else(|| format!("TransferSyntaxUID is {uid}, which is unknown"))
    }
}
