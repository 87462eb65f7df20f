"""Digital calibration certificates for tests, made after the schema of PTB (DCC 3.2 and 3.3)."""

# ruff: noqa: E501 - XML stands in one piece

from __future__ import annotations

HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<dcc:digitalCalibrationCertificate xmlns:dcc="https://ptb.de/dcc" xmlns:si="https://ptb.de/si" schemaVersion="{version}">
 <dcc:administrativeData>
  <dcc:coreData><dcc:uniqueIdentifier>K-4711</dcc:uniqueIdentifier>
   <dcc:beginPerformanceDate>2026-02-27</dcc:beginPerformanceDate>
   <dcc:endPerformanceDate>2026-03-01</dcc:endPerformanceDate></dcc:coreData>
  <dcc:calibrationLaboratory><dcc:contact><dcc:name><dcc:content lang="en">Calibration House</dcc:content></dcc:name>
  </dcc:contact></dcc:calibrationLaboratory>
 </dcc:administrativeData>
 <dcc:measurementResults><dcc:measurementResult>
  <dcc:influenceConditions><dcc:influenceCondition>
   <dcc:name><dcc:content>temperature</dcc:content></dcc:name>
   <dcc:data><dcc:quantity><si:real><si:value>20.0</si:value><si:unit>\\degreecelsius</si:unit></si:real></dcc:quantity>
   </dcc:data></dcc:influenceCondition></dcc:influenceConditions>
  <dcc:results><dcc:result><dcc:data>
"""
TAIL = "</dcc:data></dcc:result></dcc:results></dcc:measurementResult></dcc:measurementResults></dcc:digitalCalibrationCertificate>"
POINTS = """\
<dcc:quantity refType="basic_indicatedValue"><si:realListXMLList><si:valueXMLList>0 {high} 1.0</si:valueXMLList>
 <si:unitXMLList>\\milli\\metre</si:unitXMLList></si:realListXMLList></dcc:quantity>
"""
ERROR = """\
<dcc:quantity id="e1" refType="basic_measurementError"><dcc:name><dcc:content>error of indication</dcc:content></dcc:name>
 <si:realListXMLList><si:valueXMLList>0.001 -.002 0.000</si:valueXMLList><si:unitXMLList>\\milli\\metre</si:unitXMLList>
"""
LISTED = {
    "3.2.1": "<si:expandedUncXMLList><si:uncertaintyXMLList>0.003 0.004 0.003</si:uncertaintyXMLList>"
    "<si:coverageFactorXMLList>2</si:coverageFactorXMLList></si:expandedUncXMLList>",
    "3.3.0": "<si:measurementUncertaintyUnivariateXMLList><si:expandedMUXMLList><si:valueExpandedMUXMLList>0.003 0.004 0.003"
    "</si:valueExpandedMUXMLList><si:coverageFactorXMLList>2 2 2</si:coverageFactorXMLList></si:expandedMUXMLList>"
    "</si:measurementUncertaintyUnivariateXMLList>",
}
REAL = """\
<dcc:quantity><dcc:name><dcc:content>{name}</dcc:content></dcc:name><si:real><si:value>5.0</si:value>
 <si:unit>\\micro\\metre</si:unit><si:expandedUnc><si:uncertainty>4.0</si:uncertainty>
 <si:coverageFactor>2.0</si:coverageFactor></si:expandedUnc></si:real></dcc:quantity>
"""


def listed(version: str, high: str = "25") -> str:
    rows = (
        f"<dcc:list>{POINTS.format(high=high)}{ERROR}{LISTED[version]}</si:realListXMLList></dcc:quantity></dcc:list>"
    )
    return HEAD.format(version=version) + rows + TAIL


WHOLE = HEAD.format(version="3.2.1") + REAL.format(name="span") + TAIL
